//! Results in one number type as those in another.

use super::super::{Estimate, Real};

/// What has numbers of one type, with those of another in their place.
pub(crate) trait Rounded<R> {
    /// The same type with the other numbers.
    type As;

    /// Each number rounded by itself.
    fn rounded(&self) -> Self::As;
}

impl<S: Real, R: Real> Rounded<R> for S {
    type As = R;

    fn rounded(&self) -> R {
        R::from_double_double(self.to_double_double())
    }
}

impl<S: Real, R: Real> Rounded<R> for Estimate<S> {
    type As = Estimate<R>;

    /// The error is at least that of rounding.
    fn rounded(&self) -> Estimate<R> {
        let rounding = R::ROUNDOFF * self.value.abs().to_f64();
        Estimate {
            value: self.value.rounded(),
            error: self.error.max(rounding),
        }
    }
}

impl<R, T: Rounded<R>> Rounded<R> for Vec<T> {
    type As = Vec<T::As>;

    fn rounded(&self) -> Self::As {
        self.iter().map(T::rounded).collect()
    }
}

impl<R, T: Rounded<R>, const N: usize> Rounded<R> for [T; N] {
    type As = [T::As; N];

    fn rounded(&self) -> Self::As {
        self.each_ref().map(T::rounded)
    }
}

impl<R, T: Rounded<R>> Rounded<R> for Option<T> {
    type As = Option<T::As>;

    fn rounded(&self) -> Self::As {
        self.as_ref().map(T::rounded)
    }
}

impl<R, T: Rounded<R>, E: Clone> Rounded<R> for Result<T, E> {
    type As = Result<T::As, E>;

    fn rounded(&self) -> Self::As {
        self.as_ref().map(T::rounded).map_err(E::clone)
    }
}

/// What is no number stays what it is.
macro_rules! unchanged {
    ($($type:ty),*) => {$(
        impl<R> $crate::numerics::Rounded<R> for $type {
            type As = Self;

            fn rounded(&self) -> Self {
                self.clone()
            }
        }
    )*};
}
unchanged!(usize, i64, String);
pub(crate) use unchanged;

/// Defines a struct with numbers of a type, which [`Rounded`] takes to another field by field.
macro_rules! with_rounding {
    ($(#[$meta:meta])* pub struct $name:ident<R> {
        $($(#[$about:meta])* pub $field:ident: $type:ty,)*
    }) => {
        $(#[$meta])*
        pub struct $name<R> {
            $($(#[$about])* pub $field: $type,)*
        }

        impl<S: $crate::numerics::Real, R: $crate::numerics::Real> $crate::numerics::Rounded<R> for $name<S> {
            type As = $name<R>;

            fn rounded(&self) -> $name<R> {
                $name {
                    $($field: $crate::numerics::Rounded::<R>::rounded(&self.$field),)*
                }
            }
        }
    };
}
pub(crate) use with_rounding;
