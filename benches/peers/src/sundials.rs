//! The used part of SUNDIALS 6, as declared in its headers.

#![allow(non_snake_case)]

use std::ffi::{c_char, c_int, c_long, c_void};

pub type Opaque = *mut c_void;
pub type Rhs = unsafe extern "C" fn(f64, Opaque, Opaque, Opaque) -> c_int;
pub type Roots = unsafe extern "C" fn(f64, Opaque, *mut f64, Opaque) -> c_int;
pub type Jacobian =
    unsafe extern "C" fn(f64, Opaque, Opaque, Opaque, Opaque, Opaque, Opaque, Opaque) -> c_int;
pub type ErrorHandler =
    unsafe extern "C" fn(c_int, *const c_char, *const c_char, *mut c_char, Opaque);

pub const ADAMS: c_int = 1;
pub const BDF: c_int = 2;
pub const NORMAL: c_int = 1;
pub const SUCCESS: c_int = 0;
pub const STOP_RETURN: c_int = 1;
pub const ROOT_RETURN: c_int = 2;

#[link(name = "sundials_cvode")]
#[link(name = "sundials_nvecserial")]
#[link(name = "sundials_sunmatrixdense")]
#[link(name = "sundials_sunlinsoldense")]
#[link(name = "sundials_sunnonlinsolfixedpoint")]
#[link(name = "sundials_generic")]
unsafe extern "C" {
    pub fn SUNContext_Create(communicator: Opaque, context: *mut Opaque) -> c_int;
    pub fn SUNContext_Free(context: *mut Opaque) -> c_int;

    pub fn N_VNew_Serial(length: i64, context: Opaque) -> Opaque;
    pub fn N_VGetArrayPointer(vector: Opaque) -> *mut f64;
    pub fn N_VGetLength(vector: Opaque) -> i64;
    pub fn N_VDestroy(vector: Opaque);

    pub fn SUNDenseMatrix(rows: i64, columns: i64, context: Opaque) -> Opaque;
    pub fn SUNDenseMatrix_Column(matrix: Opaque, column: i64) -> *mut f64;
    pub fn SUNMatDestroy(matrix: Opaque);
    pub fn SUNLinSol_Dense(vector: Opaque, matrix: Opaque, context: Opaque) -> Opaque;
    pub fn SUNLinSolFree(solver: Opaque) -> c_int;
    pub fn SUNNonlinSol_FixedPoint(vector: Opaque, memory: c_int, context: Opaque) -> Opaque;
    pub fn SUNNonlinSolFree(solver: Opaque) -> c_int;

    pub fn CVodeCreate(method: c_int, context: Opaque) -> Opaque;
    pub fn CVodeFree(solver: *mut Opaque);
    pub fn CVodeInit(solver: Opaque, rhs: Rhs, time: f64, state: Opaque) -> c_int;
    pub fn CVodeReInit(solver: Opaque, time: f64, state: Opaque) -> c_int;
    pub fn CVodeSVtolerances(solver: Opaque, relative: f64, absolute: Opaque) -> c_int;
    pub fn CVodeSetUserData(solver: Opaque, data: Opaque) -> c_int;
    pub fn CVodeSetErrHandlerFn(solver: Opaque, handler: ErrorHandler, data: Opaque) -> c_int;
    pub fn CVodeSetMaxNumSteps(solver: Opaque, steps: c_long) -> c_int;
    pub fn CVodeSetLinearSolver(solver: Opaque, linear: Opaque, matrix: Opaque) -> c_int;
    pub fn CVodeSetJacFn(solver: Opaque, jacobian: Jacobian) -> c_int;
    pub fn CVodeSetNonlinearSolver(solver: Opaque, nonlinear: Opaque) -> c_int;
    pub fn CVodeRootInit(solver: Opaque, count: c_int, roots: Roots) -> c_int;
    pub fn CVodeSetRootDirection(solver: Opaque, directions: *mut c_int) -> c_int;
    pub fn CVodeSetNoInactiveRootWarn(solver: Opaque) -> c_int;
    pub fn CVodeGetRootInfo(solver: Opaque, found: *mut c_int) -> c_int;
    pub fn CVodeSetStopTime(solver: Opaque, time: f64) -> c_int;
    pub fn CVode(solver: Opaque, until: f64, state: Opaque, time: *mut f64, task: c_int) -> c_int;
}
