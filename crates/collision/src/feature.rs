//! Names of contact points: which vertices, edges or faces meet.

use signorini_multibody::ContactPoint;

/// What of the two shapes meets at a contact point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Feature {
    /// A vertex of A and a face (or the inside of an edge) of B.
    VertexA(u32),
    /// A vertex of B and a face (or the inside of an edge) of A.
    VertexB(u32),
    /// An edge of A, by its vertices, and an edge of B.
    Edges([u32; 2], [u32; 2]),
    /// The one closest pair of points, where no vertices or edges meet.
    Closest,
    /// The closest points of a convex shape and this triangle of a surface.
    OnTriangle(u32),
}

impl Feature {
    /// The same contact seen with A and B exchanged.
    pub fn swapped(self) -> Self {
        match self {
            Self::VertexA(i) => Self::VertexB(i),
            Self::VertexB(i) => Self::VertexA(i),
            Self::Edges(a, b) => Self::Edges(b, a),
            Self::Closest | Self::OnTriangle(_) => self,
        }
    }

    /// Vertices before edges.
    pub fn rank(self) -> u32 {
        match self {
            Self::VertexA(_) => 0,
            Self::VertexB(_) => 1,
            Self::Edges(..) => 2,
            Self::Closest | Self::OnTriangle(_) => 3,
        }
    }

    /// A 32-bit name: the same for the same feature, almost always another one for another feature.
    pub fn code(self) -> u32 {
        match self {
            Self::VertexA(i) => mix(&[1, i]),
            Self::VertexB(i) => mix(&[2, i]),
            Self::Edges([a, b], [c, d]) => mix(&[3, a.min(b), a.max(b), c.min(d), c.max(d)]),
            Self::Closest => 0,
            Self::OnTriangle(i) => mix(&[4, i]),
        }
    }
}

/// FNV-1a over 32-bit words with a final avalanche (Fowler, Noll, Vo; MurmurHash3's finalizer).
fn mix(words: &[u32]) -> u32 {
    let mut h = 0x811c_9dc5_u32;
    for w in words {
        h = (h ^ w).wrapping_mul(0x0100_0193).rotate_left(13);
    }
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// Sorts the points of a pair by feature and makes the features unique.
pub(crate) fn order_features(points: &mut [ContactPoint]) {
    if points.is_sorted_by(|p, q| p.feature < q.feature) {
        return;
    }
    points.sort_unstable_by(|p, q| {
        let place = |c: &ContactPoint| c.position.to_array();
        let ([px, py, pz], [qx, qy, qz]) = (place(p), place(q));
        let by_place = px.total_cmp(&qx).then(py.total_cmp(&qy)).then(pz.total_cmp(&qz));
        p.feature.cmp(&q.feature).then(by_place)
    });
    for k in 1..points.len() {
        if points[k].feature <= points[k - 1].feature {
            points[k].feature = points[k - 1].feature.wrapping_add(1);
        }
    }
}
