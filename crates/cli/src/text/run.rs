//! Results of `simulate` and `export` in words.

use std::fmt::Write;

use signorini::{SettleProgress, SettleReport};

use super::{bodies, count, import, laws, number};
use crate::results::{Budget, Contradiction, Exported, Involved, Place, RunResult, RunStatus};
use crate::solving::ContactLaw;

/// The summary of a run.
pub fn run(result: &RunResult) -> String {
    let mut out = format!(
        "model        {} ({}): {}, {} of freedom\n",
        result.model,
        result.source,
        bodies(result.bodies),
        count(result.nv as u64, "degree")
    );
    out.push_str(&import(&result.warnings));
    let _ = writeln!(
        out,
        "run          {} s to {} s in {} of {} s, {} solver, {} friction directions",
        number(result.time.start),
        number(result.time.end),
        count(result.steps, "step"),
        number(result.timestep),
        result.method,
        result.directions,
    );
    let _ = writeln!(out, "speed        {} steps per second", number(result.steps_per_second.round()));
    let penetration = match result.deepest_penetration {
        0.0 => "no penetration".into(),
        depth => format!("deepest penetration {} m", number(depth)),
    };
    let _ = writeln!(out, "contacts     {} at most, {penetration}", result.contacts_max);
    let (start, end) = (result.energy.start, result.energy.end);
    let _ = writeln!(out, "energy       {} J at the start, {} J at the end", number(start), number(end));
    let _ = writeln!(out, "residuals    {}", laws(&result.worst));
    if let Some(circular) = result.worst_circular.as_ref().filter(|_| result.law == ContactLaw::Polygon) {
        let _ = writeln!(out, "circular     {}", laws(circular));
    }
    out.push_str(&tolerance(result));
    if let Some(asleep) = result.bodies_asleep {
        let _ = writeln!(out, "asleep       {asleep} of {} at the end", bodies(result.bodies));
    }
    if let Some(resolution) = result.gap_resolution {
        let _ = writeln!(out, "gaps         up to {resolution:e} m count as closed");
    }
    if let Some(budget) = &result.budget {
        out.push_str(&unfinished(budget));
    }
    out.push_str(&corrections(result));
    if result.clipped_steps > 0 {
        let _ = writeln!(out, "clipped      {} with penetrations taken as zero", count(result.clipped_steps, "step"));
    }
    for (name, path) in [("recording", &result.recording), ("report", &result.report)] {
        if let Some(path) = path {
            let _ = writeln!(out, "{name:12} {}", path.display());
        }
    }
    if let Some(contradiction) = &result.contradiction {
        out.push_str(&stopped(contradiction));
    }
    if result.status == RunStatus::Interrupted {
        let _ = writeln!(out, "INTERRUPTED  at {} s; all of this is up to there", number(result.time.end));
    }
    out
}

/// What corrections of overlaps and violations did and left, where there is something to tell.
fn corrections(result: &RunResult) -> String {
    let mut out = String::new();
    if result.limited_steps > 0 {
        let _ = writeln!(
            out,
            "limited      {} kept a part of overlaps or violations that the laws do not permit to remove: θ ≥ {}, at most {} (m, rad)",
            count(result.limited_steps, "step"),
            number(result.smallest_theta),
            number(result.deepest_kept)
        );
    }
    if let Some(rise) = result.energy_from_corrections {
        let _ = writeln!(
            out,
            "corrections  the energy rose by {} J, and corrections of overlaps and violations put in {} J",
            number(rise),
            number(result.correction_energy)
        );
    }
    if result.left_out_max > 0 {
        let contacts = count(result.left_out_max as u64, "contact");
        let _ = writeln!(out, "left out     {contacts} at most that no joint can move along the normal");
    }
    out
}

/// How far a start is from rest.
pub fn settling(progress: &SettleProgress) -> String {
    let SettleProgress { steps, speed, slack, .. } = progress;
    format!("settling: step {steps}, fastest {speed:.0e}, contacts give way {slack:.0e} of the velocity scale")
}

/// How a start was brought to rest.
pub fn settled(report: &SettleReport) -> String {
    let way = match report.steps {
        0 => "the start rests".into(),
        steps => format!("the start was brought to rest in {}", count(u64::from(steps), "step")),
    };
    let (contacts, worst) = (count(report.at_rest.contacts as u64, "contact"), report.at_rest.certificate.worst());
    format!("{way}: {contacts}, worst residual {worst:.1e}")
}

/// Whether every step is within its tolerance, and where not.
fn tolerance(result: &RunResult) -> String {
    match &result.missed {
        None if result.missed_steps == 0 => {
            format!("tolerance    every step is within {:e}\n", result.tolerance)
        }
        missed => {
            let details = missed.map(|m| {
                format!(
                    ": the first at {} s, the worst at {} s ({} {:.1e})",
                    number(m.first_time),
                    number(m.worst_time),
                    m.worst_law.replace('_', " "),
                    m.worst
                )
            });
            let steps = count(result.missed_steps, "step");
            format!("tolerance    {steps} MISSED {:e}{}\n", result.tolerance, details.unwrap_or_default())
        }
    }
}

/// What a budget of sweeps left open.
fn unfinished(budget: &Budget) -> String {
    let Some(worst) = &budget.worst else {
        return format!("budget       no step used up its {} sweeps\n", budget.sweeps);
    };
    let place = worst.contact.as_ref().map_or_else(|| format!("{} {}", worst.row, worst.index), involved);
    format!(
        "budget       {} used up {} sweeps: residuals of {:.1e} at most in the root mean square, the largest {:.1e} at {} s\n  {place}\n",
        count(budget.unfinished_steps, "step"),
        budget.sweeps,
        budget.largest_rms,
        worst.residual,
        number(worst.time),
    )
}

/// Why a run could not go on.
fn stopped(contradiction: &Contradiction) -> String {
    let end = if contradiction.status == "infeasible" {
        "has no solution (infeasible): no velocity satisfies all of its contacts"
    } else {
        "was not solved (unresolved): no velocity that satisfies all of its contacts was found, nor a proof that there is none"
    };
    let mut out = format!("STOPPED      step {} at {} s {end}\n", contradiction.step, number(contradiction.time));
    for contact in &contradiction.contacts {
        let _ = writeln!(out, "  {}", involved(contact));
    }
    if contradiction.contacts.is_empty() {
        out.push_str("  the solver cannot tell which contacts are to blame\n");
    }
    out.push_str(
        "  Move the bodies apart (--set, --keyframe), or let steps remove what the laws permit (--infeasible go-on).\n",
    );
    out
}

fn involved(contact: &Involved) -> String {
    let gap = number(contact.gap);
    let [first, end] = contact.friction_rows;
    let rows = match end - first {
        0 => format!("row {}", contact.normal_row),
        _ => format!("rows {}, {first} to {}", contact.normal_row, end - 1),
    };
    match &contact.place {
        Place::Geoms { geom_a, geom_b, body_a, body_b, .. } => format!(
            "contact {}: geom '{geom_a}' (body '{body_a}') and geom '{geom_b}' (body '{body_b}'), gap {gap} m, {rows}",
            contact.contact
        ),
        Place::Limit { joint, limit } => {
            format!("contact {}: {limit} limit of joint '{joint}', gap {gap}, {rows}", contact.contact)
        }
        Place::TendonLimit { tendon, limit } => {
            format!("contact {}: {limit} limit of tendon '{tendon}', gap {gap}, {rows}", contact.contact)
        }
    }
}

/// What was exported.
pub fn export(result: &Exported) -> String {
    let mut out = format!("model        {}\n", result.source);
    out.push_str(&import(&result.warnings));
    if result.missed_steps > 0 {
        let _ = writeln!(out, "tolerance    {} before it MISSED their tolerance", count(result.missed_steps, "step"));
    }
    if let Some(contradiction) = &result.contradiction {
        out.push_str(&stopped(contradiction));
        return out;
    }
    let _ = writeln!(
        out,
        "step         from {} s to {} s: {} of freedom, {}, {} friction directions ({})",
        number(result.time),
        number(result.time + result.timestep),
        count(result.nv as u64, "degree"),
        count(result.contacts as u64, "contact"),
        result.directions,
        result.status.replace('_', " ")
    );
    if result.theta < 1.0 {
        let _ = writeln!(out, "limited      it has the part {} of its overlaps and violations", number(result.theta));
    }
    if result.clipped_gaps {
        out.push_str("clipped      its penetrations are taken as zero\n");
    }
    if let Some(path) = &result.out {
        let _ = writeln!(out, "problem      {}", path.display());
    }
    out
}
