//! COLLADA: the triangles of the scene, in metres and with z up. Materials, normals, animation, skins are passed over.
//!
//! # Source
//! COLLADA 1.4.1 specification, ch. 5 (core elements and geometry).

use std::collections::HashMap;

use signorini_multibody::glam::{DMat3, DMat4, DQuat, DVec3};
use signorini_multibody::model::Mesh;

use crate::xml::{Element, parse};

/// Scenes nested deeper than this are refused, as are those that contain themselves.
const MAX_DEPTH: usize = 64;
/// More corners than this, copies counted, are refused.
const MAX_CORNERS: usize = 30_000_000;

/// Reads all geometries that the scene shows, each where its nodes place it; without a scene each where it is.
pub(super) fn read(bytes: &[u8]) -> Result<Mesh, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "not UTF-8 text")?;
    let tree = parse(text, "COLLADA").map_err(|e| e.to_string())?;
    let root = tree.root();
    if !root.is("COLLADA") {
        return Err(format!("the root element is <{}>, expected <COLLADA>", root.name()));
    }
    let by_id = tree.elements().filter_map(|n| Some((attribute(n, "id")?, n))).collect();
    let mut scene = Scene { by_id, mesh: Mesh::default(), shapes: HashMap::new() };
    let axes = to_metres_and_z_up(root)?;
    match child(root, "scene").and_then(|s| child(s, "instance_visual_scene")) {
        Some(instance) => {
            let visual = scene.target(instance, "url")?;
            scene.add_children(visual, axes, 0)?;
        }
        None => {
            let libraries = children(root, "library_geometries");
            let geometries: Vec<Element> = libraries.flat_map(|l| children(l, "geometry")).collect();
            geometries.into_iter().try_for_each(|geometry| scene.add_geometry(geometry, axes))?;
        }
    }
    Ok(scene.mesh)
}

/// `<unit meter>` and `<up_axis>` as one map.
fn to_metres_and_z_up(root: Element) -> Result<DMat4, String> {
    let asset = child(root, "asset");
    let unit = asset.and_then(|a| child(a, "unit")).and_then(|u| attribute(u, "meter"));
    let unit: f64 = unit.map_or(Ok(1.0), |m| m.trim().parse().map_err(|_| "<unit meter> is not a number"))?;
    if !(unit.is_finite() && unit > 0.0) {
        return Err(format!("<unit meter=\"{unit}\"> is not positive"));
    }
    let up = asset.and_then(|a| child(a, "up_axis")).map(|u| u.text()).filter(|t| !t.is_empty()).unwrap_or("Y_UP");
    let turn = match up {
        "Z_UP" => DMat3::IDENTITY,
        "Y_UP" => DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y),
        "X_UP" => DMat3::from_cols(DVec3::Z, -DVec3::Y, DVec3::X),
        other => return Err(format!("<up_axis> is {other}, expected X_UP, Y_UP or Z_UP")),
    };
    Ok(DMat4::from_mat3(turn * unit))
}

/// A geometry in its own frame: points and triangles on them.
type Shape = std::rc::Rc<(Vec<DVec3>, Vec<[u32; 3]>)>;

struct Scene<'d> {
    by_id: HashMap<&'d str, Element<'d>>,
    mesh: Mesh,
    shapes: HashMap<usize, Shape>,
}

impl<'d> Scene<'d> {
    /// The element that an attribute such as `url="#id"` refers to.
    fn target(&self, node: Element<'d>, name: &str) -> Result<Element<'d>, String> {
        let place = || format!("line {}: <{}>", line(node), node.name());
        let uri = attribute(node, name).ok_or_else(|| format!("{} needs attribute '{name}'", place()))?;
        let found = uri.strip_prefix('#').and_then(|id| self.by_id.get(id)).copied();
        found.ok_or_else(|| format!("{} refers to '{uri}', which is not in the file", place()))
    }

    /// Adds what a node or a scene contains.
    fn add_children(&mut self, parent: Element<'d>, frame: DMat4, depth: usize) -> Result<(), String> {
        if depth > MAX_DEPTH {
            return Err(format!("line {}: nested more than {MAX_DEPTH} deep, or within itself", line(parent)));
        }
        for node in parent.children() {
            match node.name() {
                "node" => self.add_node(node, frame, depth)?,
                "instance_node" => self.add_node(self.target(node, "url")?, frame, depth)?,
                "instance_geometry" => self.add_geometry(self.target(node, "url")?, frame)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn add_node(&mut self, node: Element<'d>, frame: DMat4, depth: usize) -> Result<(), String> {
        self.add_children(node, frame * local_transform(node)?, depth + 1)
    }

    fn add_geometry(&mut self, geometry: Element<'d>, frame: DMat4) -> Result<(), String> {
        // Splines and convex hulls of other geometries have no triangles.
        let Some(mesh) = child(geometry, "mesh") else { return Ok(()) };
        let shape = match self.shapes.get(&geometry.index()) {
            Some(shape) => shape.clone(),
            None => {
                let shape = Shape::new(self.read_mesh(mesh)?);
                self.shapes.insert(geometry.index(), shape.clone());
                shape
            }
        };
        let (points, triangles) = &*shape;
        let first = self.mesh.vertices.len();
        if first + points.len() > MAX_CORNERS || 3 * (self.mesh.triangles.len() + triangles.len()) > MAX_CORNERS {
            return Err(format!("more than {MAX_CORNERS} corners"));
        }
        for p in points {
            let p = frame.transform_point3(*p);
            if !p.is_finite() {
                return Err(format!("line {}: a vertex is not finite", line(geometry)));
            }
            self.mesh.vertices.push(p);
        }
        let mirrored = frame.determinant() < 0.0;
        self.mesh.triangles.extend(triangles.iter().map(|t| {
            let [a, b, c] = t.map(|k| k + first as u32);
            if mirrored { [a, c, b] } else { [a, b, c] }
        }));
        Ok(())
    }

    fn read_mesh(&self, mesh: Element<'d>) -> Result<(Vec<DVec3>, Vec<[u32; 3]>), String> {
        let Some(vertices) = child(mesh, "vertices") else { return Ok(Default::default()) };
        let input = children(vertices, "input").find(|i| attribute(*i, "semantic") == Some("POSITION"));
        let input = input.ok_or_else(|| format!("line {}: <vertices> without positions", line(vertices)))?;
        let points = self.read_points(self.target(input, "source")?)?;
        let mut triangles = Vec::new();
        for primitive in mesh.children() {
            match primitive.name() {
                "triangles" => read_faces(primitive, points.len(), |_| Some(3), &mut triangles)?,
                "polylist" => {
                    let counts: Vec<usize> = numbers(child(primitive, "vcount"))?;
                    read_faces(primitive, points.len(), |face| counts.get(face).copied(), &mut triangles)?;
                }
                "polygons" => read_faces(primitive, points.len(), |_| None, &mut triangles)?,
                _ => {}
            }
        }
        Ok((points, triangles))
    }

    fn read_points(&self, source: Element<'d>) -> Result<Vec<DVec3>, String> {
        let accessor = child(source, "technique_common").and_then(|t| child(t, "accessor"));
        let own = |name| accessor.and_then(|a| attribute(a, name)).and_then(|s| s.trim().parse::<usize>().ok());
        let (stride, offset) = (own("stride").unwrap_or(3), own("offset").unwrap_or(0));
        if stride < 3 {
            return Err(format!("line {}: positions with {stride} coordinates", line(source)));
        }
        let floats: Vec<f64> = numbers(child(source, "float_array"))?;
        let rest = floats.get(offset..).unwrap_or_default();
        Ok(rest.chunks_exact(stride).map(DVec3::from_slice).collect())
    }
}

/// Adds the faces of a primitive as fans of triangles. `corners`: number of corners of each face; none where each `<p>` is
/// one face.
fn read_faces(
    primitive: Element,
    vertices: usize,
    corners: impl Fn(usize) -> Option<usize>,
    out: &mut Vec<[u32; 3]>,
) -> Result<(), String> {
    let offset =
        |input: &Element| attribute(*input, "offset").and_then(|o| o.trim().parse::<usize>().ok()).unwrap_or(0);
    let inputs: Vec<Element> = children(primitive, "input").collect();
    let stride = inputs.iter().map(offset).max().unwrap_or(0).saturating_add(1);
    let own = inputs.iter().find(|i| attribute(**i, "semantic") == Some("VERTEX")).map(offset);
    let Some(own) = own else { return Ok(()) };
    for list in children(primitive, "p") {
        let indices: Vec<usize> = numbers(Some(list))?;
        let indices: Vec<usize> = indices.chunks_exact(stride).map(|corner| corner[own]).collect();
        if let Some(k) = indices.iter().find(|&&k| k >= vertices) {
            return Err(format!("line {}: a face names vertex {k} of {vertices}", line(list)));
        }
        let (mut start, mut face) = (0, 0);
        while start < indices.len() {
            let count = corners(face).unwrap_or(indices.len()).max(1);
            let polygon = &indices[start..indices.len().min(start.saturating_add(count))];
            for pair in polygon.get(1..).unwrap_or_default().windows(2) {
                out.push([polygon[0] as u32, pair[0] as u32, pair[1] as u32]);
            }
            start = start.saturating_add(count);
            face += 1;
        }
    }
    Ok(())
}

/// The product of the transformations of a node, in their order.
fn local_transform(node: Element) -> Result<DMat4, String> {
    let mut transform = DMat4::IDENTITY;
    for element in node.children() {
        let name = element.name();
        let count = match name {
            "matrix" => 16,
            "rotate" => 4,
            "translate" | "scale" => 3,
            _ => continue,
        };
        let x: Vec<f64> = numbers(Some(element))?;
        if x.len() != count {
            return Err(format!("line {}: <{name}> has {} numbers, expected {count}", line(element), x.len()));
        }
        transform *= match name {
            "matrix" => DMat4::from_cols_slice(&x).transpose(),
            "translate" => DMat4::from_translation(DVec3::from_slice(&x)),
            "scale" => DMat4::from_scale(DVec3::from_slice(&x)),
            _ => match crate::xml::unit(DVec3::from_slice(&x)) {
                Some(axis) => DMat4::from_quat(DQuat::from_axis_angle(axis, x[3].to_radians())),
                None => DMat4::IDENTITY,
            },
        };
    }
    Ok(transform)
}

fn child<'d>(node: Element<'d>, name: &'static str) -> Option<Element<'d>> {
    children(node, name).next()
}

fn children<'d>(node: Element<'d>, name: &'static str) -> impl Iterator<Item = Element<'d>> {
    node.children_named(name)
}

fn attribute<'d>(node: Element<'d>, name: &str) -> Option<&'d str> {
    node.raw(name).map(|a| a.value.as_str())
}

/// The numbers of an element's text.
fn numbers<T: std::str::FromStr>(element: Option<Element>) -> Result<Vec<T>, String> {
    let Some(element) = element else { return Ok(Vec::new()) };
    let parsed: Result<Vec<T>, T::Err> = element.text().split_ascii_whitespace().map(str::parse).collect();
    parsed.map_err(|_| format!("line {}: <{}> holds something that is not a number", line(element), element.name()))
}

fn line(node: Element) -> u32 {
    node.at().line
}
