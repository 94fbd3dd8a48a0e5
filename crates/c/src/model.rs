//! Models.

use std::ffi::{c_char, CString};
use std::path::{Path, PathBuf};
use std::ptr;
use std::sync::Arc;

use signorini::formats::{load, load_mjcf_str, load_sdf_str, load_urdf_str, Imported, LoadOptions};
use signorini::multibody::Model;

use crate::error::{guarded, signorini_status, Failure, SIGNORINI_ERROR_FILE, SIGNORINI_OK};
use crate::pointers::{give, shared, take_back, text};

/// A model: bodies, joints, shapes, actuators. It never changes.
pub struct signorini_model {
    pub(crate) model: Arc<Model>,
    warnings: Vec<CString>,
    names: Vec<CString>,
}

/// How a file is read. Begin with signorini_load_options_default().
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct signorini_load_options {
    /// Whether the root link of a URDF floats freely; otherwise it is fixed to the world.
    pub floating_base: bool,
    /// Whether the world gets a floor (URDF, SDF): the plane z = 0.
    pub floor: bool,
    /// Whether links that a fixed joint connects become one body (URDF).
    pub merge_fixed_joints: bool,
    /// Coefficient of friction of the shapes of a URDF, which has no word for it.
    pub friction: f64,
    /// A folder in which the packages of `package://…` are looked for first, or NULL.
    pub package_dir: *const c_char,
}

/// What a text is.
pub type signorini_format = i32;
/// MuJoCo's format.
pub const SIGNORINI_MJCF: signorini_format = 0;
/// Unified Robot Description Format.
pub const SIGNORINI_URDF: signorini_format = 1;
/// Simulation Description Format.
pub const SIGNORINI_SDF: signorini_format = 2;

/// The options' defaults: a fixed base, no floor, friction 1.
#[no_mangle]
pub extern "C" fn signorini_load_options_default() -> signorini_load_options {
    let usual = LoadOptions::default();
    signorini_load_options {
        floating_base: usual.floating_base,
        floor: usual.floor,
        merge_fixed_joints: usual.merge_fixed_joints,
        friction: usual.friction,
        package_dir: ptr::null(),
    }
}

impl signorini_model {
    fn new(imported: Imported) -> Self {
        let c_text = |text: String| CString::new(text.replace('\0', " ")).unwrap_or_default();
        let warnings = imported.report.warnings.iter().map(|warning| c_text(warning.to_string())).collect();
        let names = imported.model.bodies.iter().map(|body| c_text(body.name.clone())).collect();
        Self { model: Arc::new(imported.model), warnings, names }
    }
}

/// Options of the caller, or the usual ones.
///
/// # Safety
/// `options` is null or points to options whose text is valid.
unsafe fn options_of(options: *const signorini_load_options) -> Result<LoadOptions, Failure> {
    let mut wanted = LoadOptions::default();
    // SAFETY: the caller's.
    if let Some(options) = unsafe { options.as_ref() } {
        wanted.floating_base = options.floating_base;
        wanted.floor = options.floor;
        wanted.merge_fixed_joints = options.merge_fixed_joints;
        wanted.friction = options.friction;
        if !options.package_dir.is_null() {
            // SAFETY: the caller's.
            wanted.package_dirs.push(PathBuf::from(unsafe { text(options.package_dir, "package_dir") }?));
        }
    }
    Ok(wanted)
}

/// Reads a model file: MJCF, URDF or SDF, as its root element says.
///
/// options: NULL for the defaults. What the file has and the model has not is in the model's warnings.
#[no_mangle]
pub unsafe extern "C" fn signorini_model_load(
    path: *const c_char,
    options: *const signorini_load_options,
    model: *mut *mut signorini_model,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (path, options) = unsafe { (text(path, "path")?, options_of(options)?) };
        let imported = load(path, &options).map_err(|error| Failure::new(SIGNORINI_ERROR_FILE, error))?;
        // SAFETY: the caller's.
        unsafe { give(model, signorini_model::new(imported)) }?;
        Ok(SIGNORINI_OK)
    })
}

/// Reads a model from text. Files that it names by relative paths are looked for in `folder` (NULL: the current one).
#[no_mangle]
pub unsafe extern "C" fn signorini_model_parse(
    source: *const c_char,
    format: signorini_format,
    folder: *const c_char,
    options: *const signorini_load_options,
    model: *mut *mut signorini_model,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (source, options) = unsafe { (text(source, "source")?, options_of(options)?) };
        // SAFETY: the caller's.
        let folder = if folder.is_null() { "." } else { unsafe { text(folder, "folder") }? };
        let imported = match format {
            SIGNORINI_MJCF => load_mjcf_str(source, Path::new(folder)),
            SIGNORINI_URDF => load_urdf_str(source, Path::new(folder), &options),
            SIGNORINI_SDF => load_sdf_str(source, Path::new(folder), &options),
            _ => return Err(Failure::argument(format_args!("there is no format {format}"))),
        };
        let imported = imported.map_err(|error| Failure::new(SIGNORINI_ERROR_FILE, error))?;
        // SAFETY: the caller's.
        unsafe { give(model, signorini_model::new(imported)) }?;
        Ok(SIGNORINI_OK)
    })
}

/// Frees a model. Simulations made of it keep what they need.
#[no_mangle]
pub unsafe extern "C" fn signorini_model_free(model: *mut signorini_model) {
    // SAFETY: the caller's.
    unsafe { take_back(model) }
}

/// Sizes of a model.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct signorini_sizes {
    /// Numbers of a configuration q.
    pub nq: usize,
    /// Numbers of a generalized velocity v.
    pub nv: usize,
    /// Actuators.
    pub nu: usize,
    /// Numbers of all sensors.
    pub sensordata: usize,
    /// Bodies; body 0 is the world.
    pub bodies: usize,
    /// Lines of the file that were not taken over as they are.
    pub warnings: usize,
    /// The model's time step, s.
    pub timestep: f64,
}

/// The sizes of a model.
#[no_mangle]
pub unsafe extern "C" fn signorini_model_sizes(
    model: *const signorini_model,
    sizes: *mut signorini_sizes,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, sizes) = unsafe { (shared(model, "model")?, crate::pointers::owned(sizes, "sizes")?) };
        let model = &handle.model;
        *sizes = signorini_sizes {
            nq: model.nq,
            nv: model.nv,
            nu: model.actuators.len(),
            sensordata: model.sensor_size,
            bodies: model.bodies.len(),
            warnings: handle.warnings.len(),
            timestep: model.timestep,
        };
        Ok(SIGNORINI_OK)
    })
}

/// Warning `i` of a model, with file, line and effect; NULL if there are not so many. It lives as long as the model.
#[no_mangle]
pub unsafe extern "C" fn signorini_model_warning(model: *const signorini_model, i: usize) -> *const c_char {
    // SAFETY: the caller's.
    unsafe { model.as_ref() }.and_then(|model| model.warnings.get(i)).map_or(ptr::null(), |text| text.as_ptr())
}

/// The name of a body; NULL if there are not so many. It lives as long as the model.
#[no_mangle]
pub unsafe extern "C" fn signorini_model_body_name(model: *const signorini_model, body: usize) -> *const c_char {
    // SAFETY: the caller's.
    unsafe { model.as_ref() }.and_then(|model| model.names.get(body)).map_or(ptr::null(), |text| text.as_ptr())
}

/// Runs `find` on a model and a name, and writes what it finds.
///
/// # Safety
/// The pointers are null or valid.
pub(crate) unsafe fn look_up(
    model: *const signorini_model,
    name: *const c_char,
    sort: &str,
    places: &[*mut usize],
    find: impl FnOnce(&Model, &str) -> Option<Vec<usize>>,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's.
        let (handle, name) = unsafe { (shared(model, "model")?, text(name, "name")?) };
        let found = find(&handle.model, name);
        let found = found.ok_or_else(|| Failure::argument(format_args!("the model has no {sort} '{name}'")))?;
        for (place, value) in places.iter().zip(found) {
            // SAFETY: the caller's.
            if let Some(place) = unsafe { place.as_mut() } {
                *place = value;
            }
        }
        Ok(SIGNORINI_OK)
    })
}

/// The index of a body.
#[no_mangle]
pub unsafe extern "C" fn signorini_model_body(
    model: *const signorini_model,
    name: *const c_char,
    body: *mut usize,
) -> signorini_status {
    // SAFETY: the caller's.
    unsafe { look_up(model, name, "body", &[body], |m, name| m.body_named(name).map(|id| vec![id.index()])) }
}

/// Where a joint's numbers begin in q and in v; either place may be NULL.
#[no_mangle]
pub unsafe extern "C" fn signorini_model_joint(
    model: *const signorini_model,
    name: *const c_char,
    q_index: *mut usize,
    v_index: *mut usize,
) -> signorini_status {
    let find = |m: &Model, name: &str| {
        m.joints.iter().find(|joint| joint.name == name).map(|joint| vec![joint.q_index, joint.v_index])
    };
    // SAFETY: the caller's.
    unsafe { look_up(model, name, "joint", &[q_index, v_index], find) }
}

/// The index of an actuator in the control.
#[no_mangle]
pub unsafe extern "C" fn signorini_model_actuator(
    model: *const signorini_model,
    name: *const c_char,
    actuator: *mut usize,
) -> signorini_status {
    let find = |m: &Model, name: &str| m.actuator_named(name).map(|id| vec![id.index()]);
    // SAFETY: the caller's.
    unsafe { look_up(model, name, "actuator", &[actuator], find) }
}
