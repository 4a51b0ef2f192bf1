//! Runs the checks of the stress catalogue whose identifier starts with the argument (default: C05) and prints the
//! results.
//!
//!     cargo run --release --example check -p dapple-verify -- C05

use dapple_verify::stress::{self, Effort};

fn main() -> Result<(), String> {
    let filter = std::env::args().nth(1).unwrap_or_else(|| "C05".into());
    for case in stress::select(&filter)? {
        let result = match case.run(Effort::Quick) {
            Some(o) if o.passed => format!("pass: {} (expected {})", o.measured, o.expected),
            Some(o) => format!("FAIL: {} (expected {})", o.measured, o.expected),
            None => "pending".into(),
        };
        println!("{}  {}: {result}", case.id, case.title);
    }
    Ok(())
}
