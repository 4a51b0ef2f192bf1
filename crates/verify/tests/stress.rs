//! The catalogue of `dapple stress`, with little effort: every case that can run passes.

use dapple_verify::stress::{Case, Effort, catalogue};

/// A family at a time, so that they share the cores.
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
