//! What `run.sh` needs to know.

use crate::model::Model;
use crate::solver::deck::DeckOptions;
use serde::Serialize;

/// Values of `run.sh`.
#[derive(Debug, Serialize)]
pub struct Start {
    ranks: usize,
    restarts: bool,
    springs: bool,
}

impl Start {
    /// Reads the options.
    pub fn new(model: &Model, options: &DeckOptions) -> Self {
        Self {
            ranks: options.ranks,
            restarts: model.decks.restarts > 0,
            springs: !model.springs.is_empty(),
        }
    }
}
