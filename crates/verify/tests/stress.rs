//! The catalogue of `dapple stress` at reduced effort: every case that is not pending passes.

use dapple_verify::stress::{Case, Effort, catalogue};

/// Runs one family per test, so that the families run in parallel.
fn family(letter: char) {
    let mut failed = Vec::new();
    for case in catalogue().iter().filter(|case| case.id.starts_with(letter)) {
        let start = std::time::Instant::now();
        let Some(outcome) = case.run(Effort::Quick) else { continue };
        let Case { id, title, .. } = case;
        let seconds = start.elapsed().as_secs_f64();
        println!("{id} {} {seconds:.2} s: {title}: {outcome:?}", if outcome.passed { "ok" } else { "FAILS" });
        if !outcome.passed {
            failed.push(format!("{id} {title}: {outcome:?}"));
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn geometry_and_scale() {
    family('A');
}

#[test]
fn lights() {
    family('B');
}

#[test]
fn bsdfs() {
    family('C');
}

#[test]
fn estimator_and_system() {
    family('D');
}
