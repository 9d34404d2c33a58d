//! CVODE of SUNDIALS: variable-order multistep methods with root finding.

use crate::events::{Failure, SmoothSolver};
use crate::field::Field;
use crate::sundials as c;
use crate::vectors::accelerate;
use gearatlas::model::{COAST_FLANK, DRIVE_FLANK};
use std::ffi::{c_char, c_int};
use std::ptr::null_mut;

/// Multistep method, and solution of its implicit equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// Adams–Moulton, fixed-point iteration: no matrix.
    Adams,
    /// Backward differentiation, Newton's method with the analytic dense Jacobian.
    Bdf,
}

/// Source of CVODE's vector operations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Vectors {
    /// The package, compiled for any processor.
    Packaged,
    /// The module `vectors`, compiled for this processor.
    Compiled,
}

/// A CVODE integrator, created once and reinitialised at every event.
pub struct Cvode {
    context: c::Opaque,
    solver: c::Opaque,
    state: c::Opaque,
    absolute: c::Opaque,
    matrix: c::Opaque,
    linear: c::Opaque,
    nonlinear: c::Opaque,
    dimension: usize,
}

impl Cvode {
    /// An integrator with relative tolerance `tolerance` and absolute tolerances
    /// `tolerance · scale`.
    pub fn new(
        method: Method,
        vectors: Vectors,
        field: &Field,
        tolerance: f64,
        scale: &[f64],
    ) -> Self {
        let dimension = field.dimension();
        let n = dimension as i64;
        let mut context = null_mut();
        // SAFETY: every handle comes from the library's constructor, is checked where it is
        // used first, and lives until `drop`.
        unsafe {
            check("context", c::SUNContext_Create(null_mut(), &mut context));
            let state = c::N_VNew_Serial(n, context);
            let absolute = c::N_VNew_Serial(n, context);
            assert!(!state.is_null() && !absolute.is_null(), "no vectors");
            if vectors == Vectors::Compiled {
                accelerate(state);
                accelerate(absolute);
            }
            vector(state, dimension).fill(0.0);
            for (a, s) in vector(absolute, dimension).iter_mut().zip(scale) {
                *a = tolerance * s;
            }
            let solver = c::CVodeCreate(
                if method == Method::Adams { c::ADAMS } else { c::BDF },
                context,
            );
            assert!(!solver.is_null(), "no solver");
            check(
                "handler",
                c::CVodeSetErrHandlerFn(solver, silent, null_mut()),
            );
            check("init", c::CVodeInit(solver, rhs, 0.0, state));
            check(
                "tolerances",
                c::CVodeSVtolerances(solver, tolerance, absolute),
            );
            check("steps", c::CVodeSetMaxNumSteps(solver, 1_000_000));
            let (mut matrix, mut linear, mut nonlinear) = (null_mut(), null_mut(), null_mut());
            match method {
                Method::Adams => {
                    nonlinear = c::SUNNonlinSol_FixedPoint(state, 0, context);
                    check("iteration", c::CVodeSetNonlinearSolver(solver, nonlinear));
                }
                Method::Bdf => {
                    matrix = c::SUNDenseMatrix(n, n, context);
                    linear = c::SUNLinSol_Dense(state, matrix, context);
                    check("matrix", c::CVodeSetLinearSolver(solver, linear, matrix));
                    check("jacobian", c::CVodeSetJacFn(solver, jacobian));
                }
            }
            check("roots", c::CVodeRootInit(solver, 2, roots));
            check("warning", c::CVodeSetNoInactiveRootWarn(solver));
            Self {
                context,
                solver,
                state,
                absolute,
                matrix,
                linear,
                nonlinear,
                dimension,
            }
        }
    }
}

impl SmoothSolver for Cvode {
    fn piece(
        &mut self,
        field: &Field,
        start: f64,
        end: f64,
        state: &mut [f64],
    ) -> Result<Option<(f64, usize)>, Failure> {
        // Directions in which δ − b and δ + b pass zero when this contact state ends.
        let mut directions: [c_int; 2] = if field.contact.touching() { [-1, 1] } else { [1, -1] };
        let data = std::ptr::from_ref(field).cast_mut().cast();
        // SAFETY: the handles live as long as `self`; `field` outlives the calls that see it
        // and is only read by the callbacks.
        unsafe {
            vector(self.state, self.dimension).copy_from_slice(state);
            check("data", c::CVodeSetUserData(self.solver, data));
            check("restart", c::CVodeReInit(self.solver, start, self.state));
            let directed = c::CVodeSetRootDirection(self.solver, directions.as_mut_ptr());
            check("directions", directed);
            check("stop", c::CVodeSetStopTime(self.solver, end));
            let mut time = start;
            let flag = c::CVode(self.solver, end, self.state, &mut time, c::NORMAL);
            state.copy_from_slice(vector(self.state, self.dimension));
            match flag {
                c::SUCCESS | c::STOP_RETURN => Ok(None),
                c::ROOT_RETURN => {
                    let mut found = [0; 2];
                    let info = c::CVodeGetRootInfo(self.solver, found.as_mut_ptr());
                    check("root", info);
                    let crossed = if found[0] != 0 { DRIVE_FLANK } else { COAST_FLANK };
                    Ok(Some((time, crossed)))
                }
                _ => Err(Failure(format!("CVODE ends with {flag}"))),
            }
        }
    }
}

impl Drop for Cvode {
    fn drop(&mut self) {
        // SAFETY: each handle is freed once, in the order of the manual, null ones left out.
        unsafe {
            c::CVodeFree(&mut self.solver);
            if !self.nonlinear.is_null() {
                c::SUNNonlinSolFree(self.nonlinear);
            }
            if !self.linear.is_null() {
                c::SUNLinSolFree(self.linear);
                c::SUNMatDestroy(self.matrix);
            }
            c::N_VDestroy(self.absolute);
            c::N_VDestroy(self.state);
            c::SUNContext_Free(&mut self.context);
        }
    }
}

/// Panics if the library refuses a setting, which is a mistake of this program.
fn check(what: &str, flag: c_int) {
    assert!(flag >= 0, "CVODE refuses its {what}: {flag}");
}

/// The entries of a serial vector.
///
/// # Safety
/// `handle` is a serial vector of this length that nobody else writes to.
unsafe fn vector<'a>(handle: c::Opaque, length: usize) -> &'a mut [f64] {
    // SAFETY: as the caller vouches.
    unsafe { std::slice::from_raw_parts_mut(c::N_VGetArrayPointer(handle), length) }
}

unsafe extern "C" fn silent(
    _: c_int,
    _: *const c_char,
    _: *const c_char,
    _: *mut c_char,
    _: c::Opaque,
) {
}

unsafe extern "C" fn rhs(time: f64, y: c::Opaque, out: c::Opaque, data: c::Opaque) -> c_int {
    // SAFETY: `data` is the field given to `CVodeSetUserData`; the vectors are the solver's.
    unsafe {
        let field = &*data.cast::<Field>();
        let n = field.dimension();
        field.derivative(time, vector(y, n), vector(out, n));
    }
    0
}

unsafe extern "C" fn roots(time: f64, y: c::Opaque, out: *mut f64, data: c::Opaque) -> c_int {
    // SAFETY: as in `rhs`; `out` has room for the two functions asked for.
    unsafe {
        let field = &*data.cast::<Field>();
        let (deflection, _) = field.deflection(time, vector(y, field.dimension()));
        *out = deflection - field.half_gap;
        *out.add(1) = deflection + field.half_gap;
    }
    0
}

unsafe extern "C" fn jacobian(
    _: f64,
    _: c::Opaque,
    _: c::Opaque,
    matrix: c::Opaque,
    data: c::Opaque,
    _: c::Opaque,
    _: c::Opaque,
    _: c::Opaque,
) -> c_int {
    // SAFETY: as in `rhs`; the matrix has the field's dimension.
    unsafe {
        let field = &*data.cast::<Field>();
        let n = field.dimension();
        field.jacobian(|j| {
            std::slice::from_raw_parts_mut(c::SUNDenseMatrix_Column(matrix, j as i64), n)
        });
    }
    0
}
