// ODE, double precision. Arguments: scene as numbers (scenes.py), output, scene's name, variant, seconds of CPU time.
//   quick     dWorldQuickStep, its default of 20 iterations
//   quickN    N iterations
//   step      dWorldStep, the direct boxed LCP
// World ERP 0.2 and CFM 1e-10 are ODE's defaults; contacts have no softness of their own. Writes what `protocol.py` describes.
#include <ode/ode.h>
#include <time.h>

#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

struct Contact {
  dJointID joint;
  dGeomID first, second;
  dContactGeom geom;
  dJointFeedback feedback;
};

struct World {
  dWorldID world = dWorldCreate();
  dSpaceID space = dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ);
  dJointGroupID group = dJointGroupCreate(0);
  std::vector<dBodyID> bodies;
  std::vector<Contact> contacts;
  double friction = 0;
  bool collide = true;
};

static long complaints = 0;  // "LCP internal error" of the direct solver

static double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

static void near(void* data, dGeomID a, dGeomID b) {
  World& w = *static_cast<World*>(data);
  dBodyID x = dGeomGetBody(a), y = dGeomGetBody(b);
  if (!w.collide || (!x && !y)) return;
  dContact touch[12];
  int n = dCollide(a, b, 12, &touch[0].geom, sizeof(dContact));
  for (int k = 0; k < n; k++) {
    touch[k].surface.mode = dContactApprox1;
    touch[k].surface.mu = w.friction;
    dJointID joint = dJointCreateContact(w.world, w.group, &touch[k]);
    dJointAttach(joint, x, y);
    w.contacts.push_back({joint, a, b, touch[k].geom, {}});
  }
}

static int index_of(const World& w, dGeomID geom) {
  dBodyID body = dGeomGetBody(geom);
  for (size_t k = 0; body && k < w.bodies.size(); k++)
    if (w.bodies[k] == body) return int(k);
  return -1;
}

static std::string text(const double* values, int n) {
  std::ostringstream out;
  out.precision(17);
  for (int k = 0; k < n; k++) out << (k ? "," : "") << values[k];
  return out.str();
}

static std::string state(const World& w) {
  std::string out = "[";
  for (dBodyID body : w.bodies) {
    out += (out.size() > 1 ? ",[" : "[") + text(dBodyGetPosition(body), 3) + "," + text(dBodyGetQuaternion(body), 4);
    out += "," + text(dBodyGetLinearVel(body), 3) + "," + text(dBodyGetAngularVel(body), 3) + "]";
  }
  return out + "]";
}

static std::string forces(const World& w) {
  std::string out = "[";
  for (const Contact& c : w.contacts) {
    int i = index_of(w, c.first), j = index_of(w, c.second);
    // ODE's normal points into the first geom. dJointAttach swaps the bodies when the first is the world.
    double sign = i < 0 ? -1 : 1;
    if (i < 0) std::swap(i, j);
    const dReal* f = c.feedback.f1;
    double normal[3], tangential[3], along = 0;
    for (int d = 0; d < 3; d++) normal[d] = sign * c.geom.normal[d], along += f[d] * normal[d];
    for (int d = 0; d < 3; d++) tangential[d] = f[d] - along * normal[d];
    out += (out.size() > 1 ? ",[" : "[") + std::to_string(i) + "," + std::to_string(j) + "," + text(c.geom.pos, 3) + ",";
    double gap = -c.geom.depth, corner[3];
    dVector3 across[2];
    dPlaneSpace(c.geom.normal, across[0], across[1]);  // each of the two friction directions has a bound of its own
    for (int d = 0; d < 3; d++) corner[d] = across[0][d] + across[1][d];
    out += text(normal, 3) + "," + text(&along, 1) + "," + text(tangential, 3) + "," + text(&w.friction, 1) + ",";
    out += text(&gap, 1) + "," + text(corner, 3) + "]";
  }
  return out + "]";
}

int main(int argc, char** argv) {
  if (argc != 6) return 2;
  std::ifstream in(argv[1]);
  auto read = [&] {
    double x;
    if (!(in >> x)) throw std::runtime_error("the scene ends early");
    return x;
  };
  std::string variant = argv[4];
  double cap = atof(argv[5]);
  dSetMessageHandler([](int, const char*, va_list) { complaints++; });
  dInitODE2(0);
  dAllocateODEDataForThread(dAllocateMaskAll);
  World w;
  double dt = read(), duration = read(), gravity[3] = {read(), read(), read()};
  w.friction = read();
  w.collide = read() != 0;
  int every = int(read()), planes = int(read()), bodies = int(read()), joints = int(read()), loads = int(read()), moving = int(read());
  dWorldSetGravity(w.world, gravity[0], gravity[1], gravity[2]);
  dWorldSetAutoDisableFlag(w.world, 0);
  if (variant.size() > 5 && variant.compare(0, 5, "quick") == 0) dWorldSetQuickStepNumIterations(w.world, atoi(variant.c_str() + 5));
  for (int k = 0; k < planes; k++) {
    double p[4] = {read(), read(), read(), read()};
    dCreatePlane(w.space, p[0], p[1], p[2], p[3]);
  }
  for (int k = 0; k < bodies; k++) {
    bool box = read() == 0;
    double s[3] = {read(), read(), read()}, m = read(), p[3] = {read(), read(), read()};
    dQuaternion q = {read(), read(), read(), read()};
    dMass mass;
    if (box) dMassSetBoxTotal(&mass, m, 2 * s[0], 2 * s[1], 2 * s[2]);
    else dMassSetSphereTotal(&mass, m, s[0]);
    dBodyID body = dBodyCreate(w.world);
    dBodySetMass(body, &mass);
    dBodySetPosition(body, p[0], p[1], p[2]);
    dBodySetQuaternion(body, q);
    dGeomSetBody(box ? dCreateBox(w.space, 2 * s[0], 2 * s[1], 2 * s[2]) : dCreateSphere(w.space, s[0]), body);
    w.bodies.push_back(body);
  }
  for (int k = 0; k < joints; k++) {
    bool hinge = read() == 0;
    int a = int(read()), b = int(read());
    double at[3] = {read(), read(), read()}, axis[3] = {read(), read(), read()};
    dJointID joint = hinge ? dJointCreateHinge(w.world, nullptr) : dJointCreateSlider(w.world, nullptr);
    dJointAttach(joint, w.bodies[b], a < 0 ? nullptr : w.bodies[a]);
    if (hinge) {
      dJointSetHingeAnchor(joint, at[0], at[1], at[2]);
      dJointSetHingeAxis(joint, axis[0], axis[1], axis[2]);
    } else {
      dJointSetSliderAxis(joint, axis[0], axis[1], axis[2]);
    }
  }
  std::vector<std::array<double, 4>> load(loads);
  for (auto& row : load) row = {read(), read(), read(), read()};
  for (int k = 0; k < moving; k++) {
    double v[3] = {read(), read(), read()}, spin[3] = {read(), read(), read()};
    dBodySetLinearVel(w.bodies[k], v[0], v[1], v[2]);
    dBodySetAngularVel(w.bodies[k], spin[0], spin[1], spin[2]);
  }

  int steps = int(std::lround(duration / dt)), done = 0;
  std::string samples = "[0," + state(w) + "]", counts = "0", snapshots, times, error = "null";
  double begin = cpu_seconds();
  for (int k = 0; k < steps; k++) {
    bool snapshot = k >= steps - 3 || (steps > 20 && k % (steps / 4) == steps / 8);
    std::string before = snapshot ? state(w) : "";
    double start = cpu_seconds();
    for (auto& f : load) dBodyAddForce(w.bodies[int(f[0])], f[1], f[2], f[3]);
    w.contacts.clear();
    dSpaceCollide(w.space, &w, near);
    if (snapshot)  // the list does not grow any more, so its addresses hold
      for (Contact& c : w.contacts) dJointSetFeedback(c.joint, &c.feedback);
    if (variant == "step") dWorldStep(w.world, dt);
    else dWorldQuickStep(w.world, dt);
    double end = cpu_seconds();
    times += (k ? "," : "") + std::to_string(long((end - start) * 1e9));
    done = k + 1;
    if (snapshot) {
      snapshots += (snapshots.empty() ? "" : ",") + ("{\"t\":" + std::to_string(done * dt)) + ",\"before\":" + before;
      snapshots += ",\"after\":" + state(w) + ",\"forces\":" + forces(w) + "}";
    }
    bool late = end - begin > cap, finite = std::isfinite(dBodyGetPosition(w.bodies[0])[2]);
    if (late || !finite || done % every == 0 || done == steps) {
      samples += ",[" + std::to_string(done * dt) + "," + state(w) + "]";
      counts += "," + std::to_string(w.contacts.size());
    }
    dJointGroupEmpty(w.group);
    if (!finite) error = "\"a state that is not finite\"";
    if (late || !finite) break;
  }
  std::ofstream out(argv[2]);
  out << "{\"engine\":\"ode\",\"variant\":\"" << variant << "\",\"version\":\"" << dODE_VERSION << "\",\"scene\":\"" << argv[3];
  out << "\",\"dt\":" << dt << ",\"planned\":" << steps << ",\"done\":" << done << ",\"error\":" << error;
  out << ",\"complaints\":" << complaints << ",\"step_ns\":[" << times << "],\"samples\":[" << samples << "],\"contacts\":[";
  out << counts << "],\"snapshots\":[" << snapshots << "]}\n";
}
