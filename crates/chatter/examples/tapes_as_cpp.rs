//! Prints the tapes of a model as C++: `cargo run -p chatter-dynamics --example tapes_as_cpp -- MODEL.toml`.

use chatter::flow::System;
use chatter::model::Model;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args()
        .nth(1)
        .ok_or("expected the file of a model")?;
    let model = Model::from_toml(&std::fs::read_to_string(&path)?, &path)?;
    print!("{}", System::new(&model)?.source()?);
    Ok(())
}
