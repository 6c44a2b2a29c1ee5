//! A run on disk: the whole state, lists and contact memories included, so that
//! going on gives the same bytes as never having stopped.
//!
//! Format: postcard of (magic, fingerprint of the model, state). The fingerprint
//! covers everything but the duration and what is recorded, so a finished run
//! may be resumed for longer. O(N).

use super::DemError;
use super::state::State;
use crate::model::Model;
use crate::num::random::fnv1a;

const MAGIC: u32 = 0x5249_5038;

/// The state as bytes.
pub fn write(model: &Model, state: &State) -> Result<Vec<u8>, DemError> {
    let content = (MAGIC, fingerprint(model)?, state);
    postcard::to_stdvec(&content).map_err(|error| DemError::Checkpoint(error.to_string()))
}

/// The state in `bytes`, which must belong to `model`.
pub fn read(model: &Model, bytes: &[u8]) -> Result<State, DemError> {
    let fault = |text: &str| DemError::Checkpoint(text.to_owned());
    let (magic, print, state): (u32, u64, State) = postcard::from_bytes(bytes)
        .map_err(|error| DemError::Checkpoint(format!("cannot be read: {error}")))?;
    if magic != MAGIC {
        return Err(fault("is not a checkpoint of this version"));
    }
    if print != fingerprint(model)? {
        return Err(fault("belongs to another scene (or another step, scheme or law)"));
    }
    let lengths = [state.balls.len(), state.built.len(), state.leeway.len()];
    if lengths != [model.spheres.len(); 3] {
        return Err(fault("does not fit the scene"));
    }
    Ok(state)
}

fn fingerprint(model: &Model) -> Result<u64, DemError> {
    let mut same = model.clone();
    let plan = &mut same.plan;
    (plan.steps, plan.frame_every, plan.series_every, plan.checkpoint_every) = (0, 0, 0, 0);
    plan.insist = false;
    plan.reason = crate::model::StepReason::Given;
    let bytes =
        postcard::to_stdvec(&same).map_err(|error| DemError::Checkpoint(error.to_string()))?;
    Ok(fnv1a(&bytes))
}
