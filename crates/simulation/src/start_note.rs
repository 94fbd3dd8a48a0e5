//! What a person should know about the start of a run, in words.

use signorini_multibody::{BodyId, ContactPoint, Model};

use crate::overlaps::{self, named_pairs};
use crate::settings::Settings;
use crate::workspace::Workspace;

impl Workspace {
    /// After the first step of a run: which parts of one mechanism are kept from touching, which shapes overlapped at its beginning by more
    /// than the step removes, which ones no degree of
    /// freedom parts, and whether equality constraints were violated; `None` where nothing of that is so.
    pub fn start_note(&self, model: &Model, settings: &Settings) -> Option<String> {
        let mut notes = Vec::new();
        if !self.own_overlaps.is_empty() {
            notes.push(format!(
                "parts of one mechanism overlap in the reference configuration and do not touch each other in this run: {}",
                overlaps::named(model, &self.own_overlaps)
            ));
        }
        let overlaps = self.kept_overlaps();
        if !overlaps.is_empty() {
            let speed = settings.correction_speed;
            notes.push(format!(
                "shapes overlap at the start and are driven apart at no more than {speed} m/s: {}",
                named(model, &overlaps)
            ));
        }
        let held: Vec<ContactPoint> = pairs(self.left_out().iter().filter(|point| point.gap < 0.0));
        if !held.is_empty() {
            notes.push(format!(
                "shapes overlap that no joint can move apart, and do not touch in this run: {}",
                named(model, &held)
            ));
        }
        let error = self.builder.constraint_error;
        if error > settings.assembly_tolerance && !self.builder.corrects_constraints {
            notes.push(format!(
                "equality constraints are violated by up to {error:.3e} (m, rad) at the start and are closed at no more than \
                 {} m/s and {} rad/s",
                settings.correction_speed, settings.correction_angular_speed
            ));
        }
        let awake = self.awake_from_the_start(model);
        if settings.sleeps(model) && !awake.is_empty() {
            notes.push(format!(
                "bodies that are to begin asleep begin awake, because the start is not the model's reference configuration, or something touches them \
                 or is tied to them that is awake: {}",
                overlaps::listed(awake.into_iter(), "others")
            ));
        }
        (!notes.is_empty()).then(|| notes.join("; "))
    }

    /// The names of the bodies that are to begin asleep and do not.
    fn awake_from_the_start(&self, model: &Model) -> Vec<String> {
        let bodies = (0..).map(BodyId).zip(&model.bodies);
        let awake = bodies.filter(|(id, body)| body.begins_asleep && !self.sleepers.is_asleep(*id));
        awake.map(|(_, body)| format!("'{}'", body.name)).collect()
    }

    /// Pairs of geoms that overlapped at the beginning of the last step by more than it removes, deepest first, each with its deepest
    /// point.
    pub fn kept_overlaps(&self) -> Vec<ContactPoint> {
        let rows = self.rows();
        let is_kept = |(point, gap): &(&ContactPoint, &f64)| self.builder.counted_gap(point) < **gap && **gap <= 0.0;
        let visible = |point: &&ContactPoint| self.builder.is_overlap(point);
        let kept = rows.points.iter().zip(&rows.problem.gap).filter(is_kept).map(|(point, _)| point);
        pairs(kept.filter(visible))
    }
}

/// The deepest point of each pair of geoms, deepest first.
fn pairs<'a>(points: impl Iterator<Item = &'a ContactPoint>) -> Vec<ContactPoint> {
    let mut pairs: Vec<ContactPoint> = Vec::new();
    for point in points {
        match pairs.iter_mut().find(|other| (other.geom_a, other.geom_b) == (point.geom_a, point.geom_b)) {
            Some(other) if other.gap <= point.gap => {}
            Some(other) => *other = *point,
            None => pairs.push(*point),
        }
    }
    pairs.sort_by(|a, b| a.gap.total_cmp(&b.gap));
    pairs
}

fn named(model: &Model, points: &[ContactPoint]) -> String {
    named_pairs(model, points.iter().map(|point| ([point.geom_a, point.geom_b], -point.gap)))
}
