//! Tests of the core that need no Python: `cargo test same_bits` runs one module.

mod adaptive_steps;
mod benches;
mod bodies;
mod closed_forms;
mod compositions;
mod elementary_functions;
mod elliptic_functions;
mod events_inside_steps;
mod flips;
mod forced_bodies;
mod incomplete_beta;
mod odd_requests;
mod random_starts;
mod same_bits;
mod splitting_structure;
mod tangent;
mod taylor;

use rigid::scene::{FREE, Scene, TOP};

/// The scene of tops or of free bodies.
fn scene_of(is_top: bool) -> &'static Scene {
    if is_top { &TOP } else { &FREE }
}
