//! Where a trajectory has been, and the derivative of its end by its start from that.
//!
//! On a leg the set of closed contacts stays as it is, so that a tangent moves by `e^{Gt}` in the eigenvectors of the set. Each
//! border adds one dense product, whatever the blocks in between, and a saltation where a contact opened or closed:
//!
//! ```text
//! M = T_k e^{G_k t_k} … (T_1⁻¹ T_0) J_0 e^{G_0 t_0} T_0⁻¹
//! ```

use super::ClosedModes;
use super::sets::Sets;
use super::shared::SharedBases;
use super::system::exponential;
use super::workspace::Workspace;
use crate::propagate::DenseError;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use multiversion::multiversion;

/// A stretch of a trajectory without a change of the system.
#[derive(Debug, Clone, Copy)]
pub struct Leg {
    /// The system.
    pub set: usize,
    /// How long \[s\].
    pub time: f64,
    /// The contact that opens or closes on its surface at the end, with its state where closed, and whether it closes.
    pub saltation: Option<(usize, usize, bool)>,
}

impl Workspace {
    /// Notes where the trajectory has been, from here on until that is taken.
    pub fn note_legs(&mut self) {
        self.legs = Some(Vec::new());
    }

    /// What was noted.
    pub fn take_legs(&mut self) -> Vec<Leg> {
        self.legs.take().unwrap_or_default()
    }

    /// Notes the present system.
    pub(super) fn note_set(&mut self) {
        let set = self.set;
        if let Some(legs) = &mut self.legs
            && legs.last().is_none_or(|leg| leg.set != set)
        {
            legs.push(Leg {
                set,
                time: 0.0,
                saltation: None,
            });
        }
    }

    /// Notes that time passes \[s\].
    #[inline]
    pub(super) fn note_time(&mut self, time: f64) {
        if let Some(leg) = self.legs.as_mut().and_then(|legs| legs.last_mut()) {
            leg.time += time;
        }
    }

    /// Notes that a contact opens or closes on its surface.
    pub(super) fn note_saltation(&mut self, contact: usize, state: usize, closes: bool) {
        if let Some(leg) = self.legs.as_mut().and_then(|legs| legs.last_mut()) {
            leg.saltation = Some((contact, state, closes));
        }
    }
}

impl ClosedModes<'_> {
    /// The derivative of a trajectory's end by its start: of the states of the model's blocks, first components, then second
    /// ones, 2N rows for the components `from` of the start, from the legs that were noted ([`Workspace::note_legs`]).
    ///
    /// # Errors
    /// [`DenseError`] where a basis is not to be had.
    pub fn derivative(
        &self,
        shared: &SharedBases,
        from: &[usize],
        legs: &[Leg],
    ) -> Result<Mat<f64>, DenseError> {
        let n = self.model.modes();
        let mut set = legs.first().map_or(Sets::FREE, |leg| leg.set);
        let first = shared.change(&self.model, &self.sets, [Sets::FREE, set])?;
        let [mut moved, mut room] = [0, 1].map(|_| Mat::zeros(2 * n, from.len()));
        for (j, &column) in from.iter().enumerate() {
            (moved.col_as_slice_mut(j)).copy_from_slice(first.col_as_slice(column));
        }
        for leg in legs {
            self.carry(shared, [set, leg.set], &mut moved, &mut room)?;
            set = leg.set;
            self.move_on(leg, &mut moved);
            self.salt_all(leg, &mut moved);
        }
        self.carry(shared, [set, Sets::FREE], &mut moved, &mut room)?;
        Ok(moved)
    }

    /// From the coordinates of one system to those of another.
    fn carry(
        &self,
        shared: &SharedBases,
        [from, to]: [usize; 2],
        moved: &mut Mat<f64>,
        room: &mut Mat<f64>,
    ) -> Result<(), DenseError> {
        if from != to {
            let change = shared.change(&self.model, &self.sets, [from, to])?;
            let (change, own) = (change.as_ref().as_ref(), moved.as_ref());
            matmul(room.as_mut(), Accum::Replace, change, own, 1.0, Par::Seq);
            std::mem::swap(moved, room);
        }
        Ok(())
    }

    /// Over the time of a leg.
    fn move_on(&self, leg: &Leg, moved: &mut Mat<f64>) {
        let n = self.model.modes();
        let basis = &self.slot(leg.set).basis;
        let mut e = [0; 4].map(|_| vec![0.0; n]);
        for i in 0..n {
            let own = exponential(&basis.block(i), leg.time);
            for (e, value) in e.iter_mut().zip(own.as_flattened()) {
                e[i] = *value;
            }
        }
        for j in 0..moved.ncols() {
            turn(&e, moved.col_as_slice_mut(j));
        }
    }

    /// Applies the saltation matrix at the end of a leg.
    fn salt_all(&self, leg: &Leg, moved: &mut Mat<f64>) {
        let Some((contact, state, closes)) = leg.saltation else {
            return;
        };
        let n = self.model.modes();
        let (rows, damping) = self.jump(leg.set, contact, state, closes);
        let [row, pull] = rows.map(|row| {
            let (first, second) = row.split_at(row.len() / 2);
            [&first[..n], &second[..n]].concat()
        });
        for j in 0..moved.ncols() {
            jump_by(damping, [&row, &pull], moved.col_as_slice_mut(j));
        }
    }
}

/// `e^{Gt}` of pairs, row by row, times a state.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx2", "x86_64+avx2"))]
fn turn(e: &[Vec<f64>; 4], state: &mut [f64]) {
    let n = state.len() / 2;
    let (first, second) = state.split_at_mut(n);
    let [a, b, c, d] = e.each_ref().map(|e| &e[..n]);
    let second = &mut second[..n];
    for i in 0..n {
        let (x, y) = (first[i], second[i]);
        first[i] = a[i] * x + b[i] * y;
        second[i] = c[i] * x + d[i] * y;
    }
}

/// Adds a push times what is seen of a state, in eight sums side by side.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx2", "x86_64+avx2"))]
fn jump_by(damping: f64, [row, pull]: [&[f64]; 2], state: &mut [f64]) {
    let mut sums = [0.0; 8];
    for (x, r) in state.chunks(8).zip(row.chunks(8)) {
        for ((sum, x), r) in sums.iter_mut().zip(x).zip(r) {
            *sum += x * r;
        }
    }
    let push = damping * sums.iter().sum::<f64>();
    for (x, g) in state.iter_mut().zip(pull) {
        *x += push * g;
    }
}
