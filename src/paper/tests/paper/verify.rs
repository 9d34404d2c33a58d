//! The checks of `atlas verify` with the paper's kernels.

use gearatlas::verify::Extent;
use gearatlas_paper::verify::{CHECKS, checks, run};

#[test]
fn every_line_passes() {
    let all: Vec<_> = checks().collect();
    assert_eq!(all.len(), CHECKS.len());
    let report = run(Extent::Quick, &all, &mut |_| ()).unwrap();
    assert!(report.passed() && report.lines().count() >= 60, "{report}");
    // Each of four kernels skips a mesh whose stiffness varies within its segments.
    assert_eq!(report.skips(), 4, "{report}");
    for kernel in ["dyadic", "hermite", "spectral", "fused"] {
        assert!(report.lines().any(|line| line.what.starts_with(kernel)));
    }
}
