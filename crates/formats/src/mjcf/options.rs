//! `<option>`: gravity, magnetic field, time step, whether there are contacts, other constraints, springs, dampers and forces of actuators, and
//! whether what rests sleeps.

use signorini_multibody::glam::DVec3;

use super::importer::Importer;
use crate::error::FormatError;
use crate::xml::Element;

pub(super) fn read<'t>(importer: &mut Importer<'t>, root: Element<'t>) -> Result<(), FormatError> {
    let mut gravity = DVec3::new(0.0, 0.0, -9.81);
    let mut weightless = false;
    for option in root.children_named("option") {
        let a = option.attributes();
        gravity = a.vec3("gravity")?.unwrap_or(gravity);
        if let Some(field) = a.vec3("magnetic")? {
            importer.parts.builder.magnetic(field);
        }
        if let Some(timestep) = a.number("timestep")? {
            if timestep <= 0.0 {
                return Err(a.invalid("timestep", "a positive number, s"));
            }
            importer.parts.builder.timestep(timestep);
            importer.timestep = timestep;
        }
        for flag in option.children_named("flag") {
            weightless = disabled(flag, "gravity")?.unwrap_or(weightless);
            if let Some(awake) = disabled(flag, "sleep")? {
                importer.parts.builder.sleeping(!awake);
            }
            // Without constraints there is none of any kind.
            let none = disabled(flag, "constraint")?.unwrap_or(false);
            let kinds = [
                ("contact", &mut importer.contacts_disabled),
                ("equality", &mut importer.equalities_disabled),
                ("frictionloss", &mut importer.friction_loss_disabled),
                ("limit", &mut importer.limits_disabled),
            ];
            for (kind, is_off) in kinds {
                *is_off = none || disabled(flag, kind)?.unwrap_or(*is_off);
            }
            let forces = [
                ("actuation", &mut importer.actuation_disabled),
                ("damper", &mut importer.dampers_disabled),
                ("spring", &mut importer.springs_disabled),
            ];
            for (kind, is_off) in forces {
                *is_off = disabled(flag, kind)?.unwrap_or(*is_off);
            }
        }
    }
    importer.parts.builder.gravity(if weightless { DVec3::ZERO } else { gravity });
    Ok(())
}

fn disabled(flag: Element, name: &'static str) -> Result<Option<bool>, FormatError> {
    flag.attributes().choice(name, &[("enable", false), ("disable", true)])
}
