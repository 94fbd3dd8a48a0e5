// Pinocchio's side of benchmarks/dynamics: the same tree, the same calls, one line "name nanoseconds" for each.
//
//     pinocchio FILE               times every algorithm
//     pinocchio FILE NAME CALLS    makes CALLS calls of one, for callgrind
#include <chrono>
#include <fstream>
#include <functional>
#include <iostream>
#include <sstream>
#include <map>

#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/centroidal.hpp>
#include <pinocchio/algorithm/cholesky.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody.hpp>

namespace pin = pinocchio;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// A hinge or slide about a coordinate axis gets the joint that knows it, as in a model loaded from a URDF.
static pin::JointModel joint(const std::string & kind, const Vector3d & axis)
{
  if (kind == "free") return pin::JointModelFreeFlyer();
  if (kind == "ball") return pin::JointModelSpherical();
  const bool x = axis == Vector3d::UnitX(), y = axis == Vector3d::UnitY(), z = axis == Vector3d::UnitZ();
  if (kind == "hinge")
    return x   ? pin::JointModel(pin::JointModelRX())
           : y ? pin::JointModel(pin::JointModelRY())
           : z ? pin::JointModel(pin::JointModelRZ())
               : pin::JointModel(pin::JointModelRevoluteUnaligned(axis));
  return x   ? pin::JointModel(pin::JointModelPX())
         : y ? pin::JointModel(pin::JointModelPY())
         : z ? pin::JointModel(pin::JointModelPZ())
             : pin::JointModel(pin::JointModelPrismaticUnaligned(axis));
}

// Trees with one joint at the origin of every body, as those that come from URDF files.
static pin::Model read(const char * path)
{
  pin::Model model;
  std::ifstream file(path);
  std::string line, word;
  std::vector<pin::JointIndex> link{0};
  pin::SE3 placement;
  pin::Inertia inertia;
  pin::JointIndex parent = 0;
  while (std::getline(file, line))
  {
    std::istringstream words(line);
    words >> word;
    if (word == "body")
    {
      double p[3], q[4], m, c[3], i[6];
      words >> parent;
      for (double & x : p) words >> x;
      for (double & x : q) words >> x;
      words >> m;
      for (double & x : c) words >> x;
      for (double & x : i) words >> x;
      placement = pin::SE3(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix(), Vector3d(p));
      Matrix3d about_com;
      about_com << i[0], i[3], i[4], i[3], i[1], i[5], i[4], i[5], i[2];
      inertia = pin::Inertia(m, Vector3d(c), about_com);
    }
    else if (word == "joint")
    {
      std::string kind;
      Vector3d axis;
      words >> kind >> axis[0] >> axis[1] >> axis[2];
      if (kind == "free") placement = pin::SE3::Identity();
      link.push_back(model.addJoint(link[parent], joint(kind, axis), placement, std::to_string(link.size())));
      model.appendBodyToJoint(link.back(), inertia, pin::SE3::Identity());
    }
  }
  return model;
}

int main(int count, char ** arguments)
{
  const pin::Model model = read(arguments[1]);
  pin::Data data(model);
  VectorXd v(model.nv), a(model.nv), tau(model.nv), x(model.nv);
  for (int k = 0; k < model.nv; ++k)
  {
    v[k] = 0.7 * std::sin(k + 1.0);
    a[k] = 2.0 * std::cos(k + 1.0);
    tau[k] = 5.0 * std::sin(2.0 * k);
  }
  const VectorXd q = pin::integrate(model, pin::neutral(model), v);
  const pin::JointIndex last = model.njoints - 1;
  pin::Data::Matrix6x jacobian(6, model.nv);
  jacobian.setZero();
  x = v;
  pin::crba(model, data, q);
  pin::cholesky::decompose(model, data);
  const std::vector<std::pair<std::string, std::function<void()>>> all = {
    {"kinematics", [&] { pin::forwardKinematics(model, data, q, v); }},
    {"rnea", [&] { pin::rnea(model, data, q, v, a); }},
    {"crba", [&] { pin::crba(model, data, q); }},
    {"aba", [&] { pin::aba(model, data, q, v, tau); }},
    {"factor", [&] { pin::cholesky::decompose(model, data); }},
    {"solve", [&] { x = v; pin::cholesky::solve(model, data, x); }},
    {"jacobian",
     [&] {
       pin::computeJointJacobians(model, data, q);
       pin::getJointJacobian(model, data, last, pin::LOCAL_WORLD_ALIGNED, jacobian);
     }},
    {"centroidal", [&] { pin::ccrba(model, data, q, v); }},
  };
  if (count > 3)
  {
    for (const auto & [name, call] : all)
      if (name == arguments[2])
        for (long i = 0; i < std::atol(arguments[3]); ++i) call();
    return 0;
  }
  for (const auto & [name, call] : all)
  {
    // Rounds are short so that some are not interrupted on a busy machine.
    // Rounds are short so that some are not interrupted on a busy machine.
    double best = 1e300;
    for (int round = 0; round < 600; ++round)
    {
      const auto start = std::chrono::steady_clock::now();
      for (int i = 0; i < 50; ++i) call();
      const std::chrono::duration<double, std::nano> time = std::chrono::steady_clock::now() - start;
      best = std::min(best, time.count() / 50);
    }
    std::cout << name << " " << best << "\n";
  }
}
