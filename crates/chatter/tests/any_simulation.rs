//! Short runs of models that chance has made. `fuzz/` runs the same law on whatever it comes up with.

#[path = "laws/simulation.rs"]
mod simulation;

/// Runs; `CHATTER_ANY_SIMULATIONS` sets another number, for long runs.
fn executions() -> u64 {
    let wanted = std::env::var("CHATTER_ANY_SIMULATIONS").ok();
    wanted.and_then(|text| text.parse().ok()).unwrap_or(500)
}

#[test]
fn gaps_are_never_negative_time_rises_and_runs_end() {
    let first: u64 = std::env::var("CHATTER_FIRST_SEED")
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(0);
    for seed in first..first + executions() {
        // SplitMix64, one number for each byte.
        let byte = |k: u64| {
            let mut z = (seed << 8 | k).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            (z ^ (z >> 31)) as u8
        };
        let bytes: Vec<u8> = (0..20).map(byte).collect();
        simulation::law(&bytes);
    }
}
