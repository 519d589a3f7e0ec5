use super::*;
use crate::numerics::Lanes;
use proptest::prelude::*;

/// The same numbers in both kinds.
type Both = (Registers, Lanes<LANES>);

fn both(values: [f64; LANES]) -> Both {
    let mut registers = Registers::splat(0.0);
    registers.lanes_mut().copy_from_slice(&values);
    (registers, Lanes(values))
}

fn odd() -> impl Strategy<Value = f64> {
    let special = [
        0.0,
        -0.0,
        1.0,
        -1.5,
        2.5,
        1e300,
        5e-324,
        f64::NAN,
        f64::INFINITY,
    ];
    prop_oneof![
        -1e3_f64..1e3,
        proptest::num::f64::ANY,
        proptest::sample::select(special.to_vec()),
    ]
}

fn same(what: &str, (registers, lanes): Both) -> Result<(), TestCaseError> {
    for (lane, (found, expected)) in registers.lanes().iter().zip(lanes.0).enumerate() {
        let is_same =
            found.to_bits() == expected.to_bits() || (found.is_nan() && expected.is_nan());
        prop_assert!(is_same, "{what} in lane {lane}: {found:e}, {expected:e}");
    }
    Ok(())
}

fn agree(numbers: [[f64; LANES]; 3]) -> Result<(), TestCaseError> {
    if InstructionSet::detected() != InstructionSet::Avx512 {
        return Ok(());
    }
    let [a, b, c] = numbers.map(both);
    macro_rules! same {
        ($($what:ident($($argument:ident),*);)*) => {
            $(same(stringify!($what), (Scalar::$what($($argument.0),*), Scalar::$what($($argument.1),*)))?;)*
        };
    }
    same("sum", (a.0 + b.0, a.1 + b.1))?;
    same("difference", (a.0 - b.0, a.1 - b.1))?;
    same("product", (a.0 * b.0, a.1 * b.1))?;
    same("quotient", (a.0 / b.0, a.1 / b.1))?;
    same("negative", (-a.0, -a.1))?;
    same! {
        mul_add(a, b, c);
        abs(a);
        sqrt(a);
        min(a, b);
        max(a, b);
        exp(a);
        powf(a, b);
        coarse_log2(a);
        coarse_exp2(a);
        short(a);
    }
    same("sine", (a.0.sin_cos().0, a.1.sin_cos().0))?;
    same("cosine", (a.0.sin_cos().1, a.1.sin_cos().1))?;
    let masks = [
        (a.0.less(b.0), a.1.less(b.1)),
        (a.0.at_most(b.0), a.1.at_most(b.1)),
        (a.0.at_most(a.0), a.1.at_most(a.1)),
        (a.0.is_finite(), a.1.is_finite()),
        (a.0.is_whole(), a.1.is_whole()),
        (!a.0.is_whole(), !a.1.is_whole()),
        (a.0.less(b.0) & b.0.less(c.0), a.1.less(b.1) & b.1.less(c.1)),
        (a.0.less(b.0) | b.0.less(c.0), a.1.less(b.1) | b.1.less(c.1)),
        (Mask::splat(true), Mask::splat(true)),
        (Mask::splat(false), Mask::splat(false)),
    ];
    for (registers, lanes) in masks {
        prop_assert_eq!(registers.set(), lanes.set());
        prop_assert_eq!(
            (registers.any(), registers.all()),
            (lanes.any(), lanes.all())
        );
        let selections = (
            Scalar::select(registers, a.0, b.0),
            Scalar::select(lanes, a.1, b.1),
        );
        same("selection", selections)?;
    }
    Ok(())
}

proptest! {
    #[test]
    fn registers_hold_the_bits_that_arrays_hold(
        numbers in proptest::array::uniform3(proptest::array::uniform16(odd())),
    ) {
        agree(numbers)?;
    }
}
