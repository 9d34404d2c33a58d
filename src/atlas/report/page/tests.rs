//! Pages of folders with failed points, without points, without results, and without a record.

use super::*;
use crate::analysis::{Class, PointOutcome, Status};
use crate::store::{AxisColumn, Placement, PointRow, ResultLayout, ResultWriter, TableKind};

fn row(point_id: u64) -> PointRow {
    PointRow {
        point_id,
        axis_values: vec![point_id as f64],
        outcome: PointOutcome::without_results(Status::Failed, "for a test".into()),
        multistability: None,
        orbits: None,
        chain: None,
        horizon: None,
        covariant: None,
        mesh: None,
        kernel: "volterra".into(),
        placement: Placement::default(),
    }
}

fn written(points: u64) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let layout = ResultLayout {
        requested: vec![TableKind::Poincare],
        axes: vec![AxisColumn {
            name: "speed".into(),
            unit: "rad/s".into(),
        }],
        ..ResultLayout::default()
    };
    let mut writer = ResultWriter::create(folder.path(), &layout, 0..points).unwrap();
    for point_id in 0..points {
        writer.push(row(point_id)).unwrap();
    }
    writer.finish().unwrap();
    folder
}

/// The head of a page.
fn head(folder: &Path) -> Value {
    let page = results_page(folder, PageRequest::default()).unwrap();
    let text = page.html.split("id=\"head\">").nth(1).unwrap();
    serde_json::from_str(text.split("</script>").next().unwrap()).unwrap()
}

#[test]
fn failed_points_have_a_page_with_the_columns_that_it_needs() {
    let folder = written(3);
    let head = head(folder.path());
    assert_eq!(head["motions"][0]["name"], "failed");
    assert_eq!(head["motions"][0]["points"], 3);
    assert_eq!(head["state"], Value::Null);
    let warning = head["warnings"][0].as_str().unwrap();
    assert!(warning.contains("there is no run.json"), "{warning}");
    let columns = head["tables"][0]["columns"].as_array().unwrap();
    let names: Vec<&str> = columns
        .iter()
        .map(|column| column["name"].as_str().unwrap())
        .collect();
    for name in NEEDED_BY_PROGRAMS {
        assert!(names.contains(&name), "{name}");
    }
    // A table without rows is present, and all its columns are marked as empty.
    assert_eq!(head["tables"][1]["name"], "poincare");
    assert_eq!(head["tables"][1]["rows"], 0);
    assert_eq!(head["tables"][1]["columns"], json!([]));
}

#[test]
fn only_transient_chaos_is_hatched() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = ResultWriter::create(folder.path(), &ResultLayout::default(), 0..3).unwrap();
    let classes = [Class::Chaotic, Class::TransientChaos, Class::Periodic(3)];
    for (point_id, class) in (0..).zip(classes) {
        let mut row = row(point_id);
        row.axis_values.clear();
        (row.outcome.status, row.outcome.class) = (Status::Ok, Some(class));
        writer.push(row).unwrap();
    }
    writer.finish().unwrap();
    let head = head(folder.path());
    let motions = head["motions"].as_array().unwrap().iter();
    let motions: Vec<(&str, bool)> = motions
        .map(|motion| {
            let hatched = motion["hatched"].as_bool().unwrap();
            (motion["name"].as_str().unwrap(), hatched)
        })
        .collect();
    let wanted = [
        ("period 3", false),
        ("transient chaos", true),
        ("chaotic", false),
    ];
    assert_eq!(motions, wanted);
}

/// Columns that the programs of the page assume.
const NEEDED_BY_PROGRAMS: [&str; 6] = ["point_id", "speed", "status", "reason", "class", "period"];

#[test]
fn a_folder_without_points_has_a_page() {
    let head = head(written(0).path());
    assert_eq!(head["points"], 0);
    assert_eq!(head["tables"][0]["rows"], 0);
}

#[test]
fn a_folder_without_results_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let error = results_page(folder.path(), PageRequest::default()).unwrap_err();
    assert!(
        matches!(error, ReportError::Store(StoreError::Missing { .. })),
        "{error}"
    );
}

#[test]
fn every_part_has_its_place_in_the_skeleton() {
    let mut from = 0;
    for part in [
        "licence", "styles", "title", "head", "first", "programs", "blocks",
    ] {
        let place = format!("{{{{{part}}}}}");
        assert_eq!(PAGE.matches(&place).count(), 1, "{part}");
        let at = PAGE.find(&place).unwrap();
        assert!(at >= from, "{part} comes too early");
        from = at;
    }
    assert_eq!(in_html("<a & b>"), "&lt;a &amp; b&gt;");
    let value = json!({ "text": "</script><!--" });
    assert!(!in_script(&value).contains('<'));
    let back: Value = serde_json::from_str(&in_script(&value)).unwrap();
    assert_eq!(back, value);
}
