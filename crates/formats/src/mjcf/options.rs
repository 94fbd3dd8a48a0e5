//! `<option>`: gravity and time step.

use signorini_multibody::glam::DVec3;

use super::Importer;
use crate::error::FormatError;
use crate::xml::Element;

pub(super) fn read<'t>(importer: &mut Importer<'t>, root: Element<'t>) -> Result<(), FormatError> {
    let mut gravity = DVec3::new(0.0, 0.0, -9.81);
    let mut weightless = false;
    for option in root.children_named("option") {
        let a = option.attributes();
        gravity = a.vec3("gravity")?.unwrap_or(gravity);
        if let Some(timestep) = a.number("timestep")? {
            if timestep <= 0.0 {
                return Err(a.invalid("timestep", "a positive number, s"));
            }
            importer.parts.builder.timestep(timestep);
        }
        for flag in option.children_named("flag") {
            let switch = flag.attributes().choice("gravity", &[("enable", false), ("disable", true)])?;
            weightless = switch.unwrap_or(weightless);
        }
    }
    importer.parts.builder.gravity(if weightless { DVec3::ZERO } else { gravity });
    Ok(())
}
