//! What happens to the state: one pure function.

use super::message::{Effect, Message};
use super::state::App;

/// Takes a message into the state; what is to be done about it is the caller's.
pub fn update(app: &mut App, message: Message) -> Vec<Effect> {
    let _ = (app, message);
    Vec::new()
}
