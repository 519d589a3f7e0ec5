//! What the faces of Chatter have in common: from a request to an answer.
//!
//! A model comes from a [`source`]; what is asked is read from text by [`options`]; each analysis has a folder, which takes the
//! request to columns, a JSON document, a table and a figure. An [`Observer`] hears of progress and may stop the work; what
//! cannot be answered is a [`Refusal`]. Nothing here knows of terminals, colours or exit codes.

pub mod backend;
pub mod border;
pub mod columns;
pub mod data_files;
pub mod diagram;
pub mod drawing;
pub mod exponents;
pub mod journals;
pub mod json;
pub mod model_tables;
pub mod named;
pub mod numbers;
pub mod observer;
pub mod options;
pub mod parallel;
pub mod periodic;
pub mod refusal;
pub mod shipped;
pub mod simulation;
pub mod source;
pub mod universal;

pub use observer::{Observer, Silent};
pub use refusal::Refusal;
