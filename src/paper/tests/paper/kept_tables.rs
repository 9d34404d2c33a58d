//! Do stored tables give the bits of newly computed tables, for every load, gap and speed for which they are valid, and
//! are those of another model refused?

use crate::common::advance::{Events, advance_with, follows_volterra, settled};
use crate::common::{self, Case};
use gearatlas::model::TrajectoryState;
use gearatlas::propagate::{KeptTables, Kernel, TableArray, TableError};
use gearatlas_paper::kernels::{DenseError, Dyadic, Fused, Spectral};

const CELLS: u32 = 60;

/// The same drive with another load and gap.
fn other_load(case: &Case) -> Case {
    let mut case = case.clone();
    case.2.load *= 1.7;
    case.1.half_gap *= 1.3;
    case
}

fn bits<K: Kernel>(kernel: &K, start: &TrajectoryState) -> (Vec<u64>, usize) {
    let mut events = Events::default();
    let (end, _) = advance_with(kernel, start, 20, &mut events);
    (
        end.state.iter().map(|x| x.to_bits()).collect(),
        events.0.len(),
    )
}

/// Tables stored for one load are valid for any other, with the bits of new tables.
#[test]
fn a_kept_table_gives_the_bits_of_a_new_one() {
    for case in [common::six_modes(), common::forty_modes()] {
        let (built, used) = (common::model(&case), common::model(&other_load(&case)));
        let start = settled(&used, 40);
        let bases = Spectral::arrays(&built).unwrap();
        let runs = Fused::arrays(&built, CELLS).unwrap();
        assert_eq!(Spectral::arrays(&used).unwrap(), bases);
        assert_eq!(Fused::arrays(&used, CELLS).unwrap(), runs);
        let both: [&dyn KeptTables; 2] = [&bases, &runs];
        for (name, new, kept) in [
            (
                "spectral",
                bits(&Spectral::new(&used, CELLS, 99, None).unwrap(), &start),
                bits(
                    &Spectral::from_kept(&used, CELLS, 99, None, &bases).unwrap(),
                    &start,
                ),
            ),
            (
                "fused",
                bits(&Fused::new(&used, CELLS, 99).unwrap(), &start),
                bits(&Fused::from_kept(&used, CELLS, 99, both).unwrap(), &start),
            ),
        ] {
            assert!(new.1 > 10, "{} events", new.1);
            assert_eq!(new, kept, "{name}");
        }
    }
}

/// Bases are bitwise equal at every speed. A kernel that uses them at another speed follows the structured one as well
/// as with new bases.
#[test]
fn bases_serve_every_speed_and_excitation() {
    for (name, case) in common::drives() {
        let own = common::model(&case);
        let arrays = Spectral::arrays(&own).unwrap();
        for other in common::other_speeds(&case) {
            let model = common::model(&other);
            assert_eq!(Spectral::arrays(&model).unwrap(), arrays, "{name}");
            let kernel = Spectral::from_kept(&model, CELLS, 1000, None, &arrays).unwrap();
            let name = format!("{name} {}", other.2.speed);
            follows_volterra(&name, &model, &kernel);
        }
    }
}

/// Tables of another drive, and truncated arrays, are refused by name.
#[test]
fn tables_of_another_model_are_refused() {
    let (two, six) = (
        common::model(&common::two_modes()),
        common::model(&common::six_modes()),
    );
    let mut arrays = Spectral::arrays(&two).unwrap();
    arrays.extend(Fused::arrays(&two, CELLS).unwrap());
    let from_kept = |model, arrays: &Vec<TableArray>| {
        let both: [&dyn KeptTables; 2] = [arrays, arrays];
        Fused::from_kept(model, CELLS, 9, both).map(|_| ())
    };
    assert_eq!(from_kept(&two, &arrays), Ok(()));
    let refused = from_kept(&six, &arrays);
    assert!(
        matches!(refused, Err(DenseError::Table(TableError::Kept { .. }))),
        "{refused:?}"
    );
    for (index, array) in arrays.iter().enumerate() {
        // This array only describes a basis. The basis does not use it.
        if array.name == "touching" {
            continue;
        }
        for change in [-1, 1] {
            let mut other = arrays.clone();
            let mut values = other[index].values.to_vec();
            values.resize(values.len().saturating_add_signed(change), 0.0);
            other[index].values = values[..].into();
            let refused = from_kept(&two, &other);
            assert_eq!(refused, Err(TableError::Kept { name: array.name }.into()));
        }
    }
}

/// The predicted size of dyadic tables is that of the built tables.
#[test]
fn the_dyadic_size_is_known_without_building() {
    for (name, case) in common::drives() {
        let model = common::model(&case);
        let built = Dyadic::new(&model, CELLS, 9).unwrap().bytes();
        assert_eq!(Dyadic::size(&model, CELLS).unwrap(), built, "{name}");
    }
}
