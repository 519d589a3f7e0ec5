//! `NAME=EXPR`: what a parameter or an initial value is set to.

/// Name and expression on either side of an equals sign.
#[derive(Clone, Debug)]
pub struct Assignment {
    /// Of what.
    pub name: String,
    /// The expression.
    pub text: String,
}

impl Assignment {
    /// Of an expression to a name.
    pub fn new(name: &str, text: &str) -> Self {
        Self {
            name: name.to_owned(),
            text: text.to_owned(),
        }
    }

    /// Name and expression.
    pub fn pair(&self) -> (String, String) {
        (self.name.clone(), self.text.clone())
    }
}

impl std::str::FromStr for Assignment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = text
            .split_once('=')
            .ok_or("expected NAME=EXPR, such as q=0.0195")?;
        Ok(Self {
            name: name.trim().to_owned(),
            text: value.trim().to_owned(),
        })
    }
}
