//! Refusals as JSON: the messages of the command line, and the places that they are about.

use chatter::model::{ModelError, Palette};
use chatter_work::Refusal;
use serde_json::{Value, json};

/// What the page shows. `text` is that of the model, `name` what its errors call it.
pub fn document(refusal: &Refusal, name: &str, text: &str) -> Value {
    let part = |error: &ModelError| model_error(error, name, text);
    match refusal {
        Refusal::Model(errors) => {
            let errors: Vec<Value> = errors.errors().iter().map(part).collect();
            json!({ "kind": "model", "message": told(&errors), "errors": errors })
        }
        Refusal::ModelPart(error) => {
            let errors = vec![part(error)];
            json!({ "kind": "model", "message": told(&errors), "errors": errors })
        }
        Refusal::Input { message, help } => {
            json!({ "kind": "input", "message": message, "help": help })
        }
        Refusal::Unfinished { message, help } => {
            json!({ "kind": "unfinished", "message": message, "help": help })
        }
        Refusal::Output(message) => json!({ "kind": "output", "message": message }),
        Refusal::Interrupted => json!({ "kind": "interrupted", "message": "broken off" }),
    }
}

fn told(errors: &[Value]) -> String {
    let first = errors.first().and_then(|error| error["message"].as_str());
    first.unwrap_or_default().to_owned()
}

/// One error: `from` and `to` count as JavaScript counts, where it is in the model's own text.
fn model_error(error: &ModelError, name: &str, text: &str) -> Value {
    let (line, column) = error.line_and_column();
    let here = error.source_name() == name;
    let place = |at: usize| {
        let before = text.get(..at).unwrap_or(text);
        here.then(|| before.encode_utf16().count())
    };
    let span = error.span();
    json!({
        "message": error.kind().to_string(),
        "label": error.kind().label(),
        "help": error.kind().help(),
        "source": error.source_name(),
        "line": line,
        "column": column,
        "from": place(span.start),
        "to": place(span.end),
        "rendered": error.render(Palette::Plain),
    })
}
