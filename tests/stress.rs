//! The commands that check this build, and the bias report.

mod dapple;

use dapple::run;
use serde_json::Value;

#[test]
fn chosen_cases_come_as_a_table_as_json_and_as_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let told = run(folder.path(), &["stress", "--case", "b16,C12,A1*", "--json", "-o", "out"]);
    let report = told.json();
    let cases = report["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 12);
    let fails = cases.iter().any(|case| case["passed"] == false);
    assert_eq!(told.code, i32::from(fails), "{}", told.err);
    let of = |id: &str| cases.iter().find(|case| case["id"] == id).unwrap();
    assert_eq!(of("B16")["passed"], true);
    for key in ["expected", "measured", "error", "tolerance", "note", "naive", "source"] {
        assert!(!of("B16")[key].is_null(), "{key}");
    }
    assert!(of("C12")["passed"].is_null() && of("C12")["pending"].as_str().unwrap().contains("multiple"));
    let page = std::fs::read_to_string(folder.path().join("out/stress.html")).unwrap();
    assert!(page.contains("B16") && !page.contains("http"), "a self-contained file");
    assert_eq!(
        std::fs::read_dir(folder.path().join("out")).unwrap().count(),
        1,
        "no unfinished file is left"
    );
    let table = run(folder.path(), &["stress", "--case", "B16"]);
    assert!(table.out.contains("B16  pass") && table.err.contains("1 pass, 0 fail"));
}

#[test]
fn unknown_cases_are_bad_input() {
    let folder = tempfile::tempdir().unwrap();
    for bad in ["Z1", "A3", "", "A03,,"] {
        let told = run(folder.path(), &["stress", "--case", bad]);
        assert_eq!((told.code, told.err.lines().count()), (2, 1), "{bad}: {}", told.err);
    }
}

fn ledger(arguments: &[&str]) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let common =
        ["render", "builtin:cornell", "--size", "24x24", "--spp", "16", "-o", "x.png", "--json", "--quiet"];
    let told = run(folder.path(), &[&common[..], arguments].concat());
    assert_eq!(told.code, 0, "{}", told.err);
    told.json()["ledger"].clone()
}

#[test]
fn clean_settings_alter_nothing() {
    let clean = ledger(&["--max-bounces", "100000"]);
    assert_eq!(clean["clean"], true);
    for entry in ["clamped", "not_finite", "depth_cut", "faint"] {
        assert_eq!(clean[entry]["count"], 0, "{entry}");
    }
}

#[test]
fn what_is_taken_away_is_written_down() {
    let clamped = ledger(&["--clamp", "1"]);
    assert_eq!(clamped["clean"], false);
    assert!(
        clamped["clamped"]["count"].as_u64() > Some(0) && clamped["clamped"]["energy"].as_f64() > Some(0.0)
    );
    let cut = ledger(&["--max-bounces", "2"]);
    // Most paths scatter a third time, and each would return at most its own throughput.
    let (count, energy) =
        (cut["depth_cut"]["count"].as_f64().unwrap(), cut["depth_cut"]["energy"].as_f64().unwrap());
    assert!(count > 2000.0 && energy > 0.0 && energy < count, "{count} {energy}");
    assert_eq!(ledger(&["--no-roulette"])["roulette_off"], true);
    let ambient = ledger(&["--diffuse", "0", "--ambient", "0.1,0.1,0.1"]);
    assert_eq!((&ambient["ambient"], &ambient["clean"]), (&Value::Bool(true), &Value::Bool(false)));
}

#[test]
fn clamps_are_numbers_above_zero_and_samples_can_be_counted() {
    let folder = tempfile::tempdir().unwrap();
    for bad in [
        &["--clamp", "0"],
        &["--clamp", "-1"],
        &["--clamp", "nan"],
        &["--clamp", "inf"],
        &["--spp", "4294967296"],
    ] {
        let told = run(folder.path(), &[&["render", "-o", "x.png"], &bad[..]].concat());
        assert_eq!((told.code, told.err.lines().count()), (2, 1), "{bad:?}: {}", told.err);
    }
}
