//! Contact problems alone: matrices of one's own, solved and certified.

use std::ffi::c_char;
use std::ptr;

use signorini::contact::problem_file::{read, write_contact, ProblemFile};
use signorini::contact::{certify, ContactProblem, ContactSolution, ContactSolver, FrictionPolygon, SolveStatus};
use signorini::multibody::BlockDiagonal;

use crate::error::{
    guarded, keep_message, signorini_status, Failure, SIGNORINI_ERROR_FILE, SIGNORINI_MISSED_TOLERANCE,
    SIGNORINI_NO_SOLUTION, SIGNORINI_OK,
};
use crate::pointers::{array, check_length, give, owned, shared, take_back, text};
use crate::report::signorini_certificate;
use crate::simulation::signorini_simulation;

/// A contact problem: M, v_free, Δt; of each contact its Jacobian rows, gap, friction and directions; bilateral rows. With the solution that
/// was found last.
pub struct signorini_problem {
    problem: ContactProblem,
    solver: ContactSolver,
    solution: ContactSolution,
}

/// Sizes of a contact problem.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct signorini_problem_sizes {
    /// Degrees of freedom.
    pub nv: usize,
    /// Contacts.
    pub nc: usize,
    /// Friction directions of all contacts.
    pub directions: usize,
    /// Bilateral rows.
    pub nb: usize,
}

impl signorini_problem {
    fn new(problem: ContactProblem) -> Self {
        Self { problem, solver: ContactSolver::default(), solution: ContactSolution::default() }
    }
}

/// The entries of dense rows that are not zero, column by column.
fn columns<const R: usize>(rows: [&[f64]; R]) -> Vec<(u32, [f64; R])> {
    let entries = (0..rows[0].len()).map(|k| (k as u32, rows.map(|row| row[k])));
    entries.filter(|(_, entry)| entry.iter().any(|x| *x != 0.0)).collect()
}

/// A contact problem without contacts. mass: nv × nv, symmetric and positive definite; free_velocity: nv numbers; timestep in s.
#[no_mangle]
pub unsafe extern "C" fn signorini_problem_new(
    nv: usize,
    mass: *const f64,
    free_velocity: *const f64,
    timestep: f64,
    problem: *mut *mut signorini_problem,
) -> signorini_status {
    guarded(|| {
        let size = nv.checked_mul(nv).ok_or_else(|| Failure::argument("nv is too large"))?;
        // SAFETY: the caller's; see the crate.
        let (mass, velocity) = unsafe { (array(mass, size, "mass")?, array(free_velocity, nv, "free_velocity")?) };
        let mass = BlockDiagonal::from_dense(nv, mass).map_err(Failure::problem)?;
        let made = ContactProblem::new(mass, velocity.to_vec(), timestep).map_err(Failure::problem)?;
        // SAFETY: the caller's.
        unsafe { give(problem, signorini_problem::new(made)) }?;
        Ok(SIGNORINI_OK)
    })
}

/// A copy of the contact problem of a simulation's last step: first its contact points, then limits of joints and tendons.
#[no_mangle]
pub unsafe extern "C" fn signorini_problem_of_step(
    simulation: *const signorini_simulation,
    problem: *mut *mut signorini_problem,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let handle = unsafe { shared(simulation, "simulation") }?;
        // SAFETY: the caller's.
        unsafe { give(problem, signorini_problem::new(handle.inner.workspace().problem().clone())) }?;
        Ok(SIGNORINI_OK)
    })
}

/// Reads a problem file (.npz).
#[no_mangle]
pub unsafe extern "C" fn signorini_problem_load(
    path: *const c_char,
    problem: *mut *mut signorini_problem,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let path = unsafe { text(path, "path") }?;
        let failure = |error: &dyn std::fmt::Display| Failure::new(SIGNORINI_ERROR_FILE, error);
        let ProblemFile::Contact(read) = read(path).map_err(|error| failure(&error))? else {
            return Err(failure(&format_args!("{path}: not a contact problem")));
        };
        // SAFETY: the caller's.
        unsafe { give(problem, signorini_problem::new(*read)) }?;
        Ok(SIGNORINI_OK)
    })
}

/// Writes a problem file (.npz) for `signorini solve`, `signorini check` and Python.
#[no_mangle]
pub unsafe extern "C" fn signorini_problem_save(
    problem: *const signorini_problem,
    path: *const c_char,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, path) = unsafe { (shared(problem, "problem")?, text(path, "path")?) };
        write_contact(path, &handle.problem).map_err(|error| Failure::new(SIGNORINI_ERROR_FILE, error))?;
        Ok(SIGNORINI_OK)
    })
}

/// Frees a contact problem with its solution.
#[no_mangle]
pub unsafe extern "C" fn signorini_problem_free(problem: *mut signorini_problem) {
    // SAFETY: the caller's.
    unsafe { take_back(problem) }
}

/// Adds a contact. jn: nv numbers; jt: 2 × nv numbers; gap in m, negative when penetrating; friction ≥ 0; directions: an even number, at
/// least 4, the first one at `angle` rad from the first tangent.
#[no_mangle]
pub unsafe extern "C" fn signorini_problem_add_contact(
    problem: *mut signorini_problem,
    jn: *const f64,
    jt: *const f64,
    gap: f64,
    friction: f64,
    directions: u32,
    angle: f64,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let handle = unsafe { owned(problem, "problem") }?;
        let nv = handle.problem.nv();
        // SAFETY: the caller's.
        let (jn, jt) = unsafe { (array(jn, nv, "jn")?, array(jt, 2 * nv, "jt")?) };
        let polygon = FrictionPolygon::regular(directions as usize, angle).map_err(Failure::problem)?;
        let numbers = [gap, friction, angle];
        if numbers.iter().chain(jn).chain(jt).any(|x| !x.is_finite()) || friction < 0.0 {
            return Err(Failure::problem("a contact's numbers must be finite, and its friction at least 0"));
        }
        handle.problem.push_contact(columns([jn, &jt[..nv], &jt[nv..]]), gap, friction, &polygon);
        Ok(SIGNORINI_OK)
    })
}

/// Adds a bilateral row: row · v⁺ + violation/Δt = 0. row: nv numbers; violation in m or rad.
#[no_mangle]
pub unsafe extern "C" fn signorini_problem_add_bilateral(
    problem: *mut signorini_problem,
    row: *const f64,
    violation: f64,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let handle = unsafe { owned(problem, "problem") }?;
        // SAFETY: the caller's.
        let row = unsafe { array(row, handle.problem.nv(), "row") }?;
        if row.iter().chain([&violation]).any(|x| !x.is_finite()) {
            return Err(Failure::problem("a row's numbers must be finite"));
        }
        handle.problem.push_bilateral(columns([row]), violation);
        Ok(SIGNORINI_OK)
    })
}

/// The sizes of a contact problem.
#[no_mangle]
pub unsafe extern "C" fn signorini_problem_sizes_of(
    problem: *const signorini_problem,
    sizes: *mut signorini_problem_sizes,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, sizes) = unsafe { (shared(problem, "problem")?, owned(sizes, "sizes")?) };
        let problem = &handle.problem;
        *sizes = signorini_problem_sizes {
            nv: problem.nv(),
            nc: problem.contact_count(),
            directions: problem.direction_count(),
            nb: problem.bilateral_violation.len(),
        };
        Ok(SIGNORINI_OK)
    })
}

/// Solves a contact problem; the solution is read by the functions below.
#[no_mangle]
pub unsafe extern "C" fn signorini_problem_solve(problem: *mut signorini_problem) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let handle = unsafe { owned(problem, "problem") }?;
        handle.problem.check().map_err(Failure::problem)?;
        handle.solution = handle.solver.solve(&handle.problem, None);
        let named = |what: &str, contacts: &[usize]| {
            keep_message(&format!("{what}: contacts {contacts:?}"));
            SIGNORINI_NO_SOLUTION
        };
        Ok(match &handle.solution.status {
            SolveStatus::Solved => SIGNORINI_OK,
            SolveStatus::Ray { contacts } => named("these wedge each other", contacts),
            SolveStatus::Infeasible { contacts } => named("the gaps of these contradict each other", contacts),
            _ => SIGNORINI_MISSED_TOLERANCE,
        })
    })
}

/// What of a solution is asked for.
pub type signorini_quantity = i32;
/// v⁺, nv numbers, m/s and rad/s.
pub const SIGNORINI_VELOCITY: signorini_quantity = 0;
/// Impulses along normal and tangents, 3 × nc, N·s.
pub const SIGNORINI_IMPULSE: signorini_quantity = 1;
/// λ_N, nc numbers, N·s.
pub const SIGNORINI_LAMBDA_N: signorini_quantity = 2;
/// α, one number for each direction, N·s.
pub const SIGNORINI_ALPHA: signorini_quantity = 3;
/// β, nc numbers, m/s.
pub const SIGNORINI_BETA: signorini_quantity = 4;
/// λ_B, nb numbers.
pub const SIGNORINI_BILATERAL: signorini_quantity = 5;

/// A part of the last solution, to be read until the next call with this problem that changes it; its length in `length`, which may be NULL.
/// NULL where there is no such part.
#[no_mangle]
pub unsafe extern "C" fn signorini_problem_solution(
    problem: *const signorini_problem,
    quantity: signorini_quantity,
    length: *mut usize,
) -> *const f64 {
    // SAFETY: the caller's.
    let Some(handle) = (unsafe { problem.as_ref() }) else { return ptr::null() };
    let solution = &handle.solution;
    let numbers: &[f64] = match quantity {
        SIGNORINI_VELOCITY => &solution.velocity,
        SIGNORINI_IMPULSE => solution.impulse.as_flattened(),
        SIGNORINI_LAMBDA_N => &solution.lambda_n,
        SIGNORINI_ALPHA => &solution.alpha,
        SIGNORINI_BETA => &solution.beta,
        SIGNORINI_BILATERAL => &solution.bilateral,
        _ => return ptr::null(),
    };
    // SAFETY: the caller's.
    if let Some(length) = unsafe { length.as_mut() } {
        *length = numbers.len();
    }
    numbers.as_ptr()
}

/// The certificate of the last solution.
#[no_mangle]
pub unsafe extern "C" fn signorini_problem_certificate(
    problem: *const signorini_problem,
    certificate: *mut signorini_certificate,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, certificate) = unsafe { (shared(problem, "problem")?, owned(certificate, "certificate")?) };
        *certificate = signorini_certificate::from(&handle.solution.certificate);
        Ok(SIGNORINI_OK)
    })
}

/// Certifies anybody's solution, from the data alone. velocity: nv numbers; lambda_n, beta: nc; alpha: one for each direction; bilateral: nb. A
/// problem of a step with friction groups (in joints, at servos, against rolling) is refused: its solution has more parts.
#[no_mangle]
pub unsafe extern "C" fn signorini_problem_certify(
    problem: *const signorini_problem,
    velocity: *const f64,
    lambda_n: *const f64,
    alpha: *const f64,
    beta: *const f64,
    bilateral: *const f64,
    certificate: *mut signorini_certificate,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, certificate) = unsafe { (shared(problem, "problem")?, owned(certificate, "certificate")?) };
        let problem = &handle.problem;
        check_length("friction groups", problem.friction_groups.len(), 0)?;
        let (nv, nc, nb) = (problem.nv(), problem.contact_count(), problem.bilateral_violation.len());
        let mut claimed = ContactSolution::default();
        // SAFETY: the caller's.
        unsafe {
            claimed.velocity = array(velocity, nv, "velocity")?.to_vec();
            claimed.lambda_n = array(lambda_n, nc, "lambda_n")?.to_vec();
            claimed.alpha = array(alpha, problem.direction_count(), "alpha")?.to_vec();
            claimed.beta = array(beta, nc, "beta")?.to_vec();
            claimed.bilateral = array(bilateral, nb, "bilateral")?.to_vec();
        }
        *certificate = signorini_certificate::from(&certify(problem, &claimed));
        Ok(SIGNORINI_OK)
    })
}
