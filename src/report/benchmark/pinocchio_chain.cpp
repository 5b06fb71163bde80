#include "report/benchmark/pinocchio_chain.h"

#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/config.hpp>

namespace planar_chain::benchmarks {

namespace {

pinocchio::Model modelOf(const Chain& chain) {
  pinocchio::Model model;
  model.gravity.linear() << chain.gravity().x, chain.gravity().y, 0;
  pinocchio::JointIndex inner = 0;
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  for (int i = 0; i < chain.size(); ++i) {
    const Link& link = chain.links()[static_cast<std::size_t>(i)];
    const Joint& joint = chain.joints()[static_cast<std::size_t>(i)];
    const pinocchio::SE3 place(Eigen::Matrix3d::Identity(), at);
    inner =
        joint.isPrismatic
            ? model.addJoint(inner, pinocchio::JointModelPrismaticUnaligned(joint.axis.x, joint.axis.y, 0),
                             place, std::to_string(i))
            : model.addJoint(inner, pinocchio::JointModelRZ(), place, std::to_string(i));
    model.appendBodyToJoint(inner, pinocchio::Inertia(link.mass, {link.com.x, link.com.y, 0},
                                                      Eigen::Vector3d::Constant(link.inertia).asDiagonal()));
    at << link.pin.x, link.pin.y, 0;
  }
  return model;
}

class InJointCoordinates : public PinocchioChain {
 public:
  explicit InJointCoordinates(const Chain& chain) : model_(modelOf(chain)), data_(model_) {
    const Eigen::Index n = chain.size();
    for (Eigen::VectorXd* each : {&q_, &qd_, &tau_, &k_, &d_, &rest_}) *each = Eigen::VectorXd::Zero(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Joint& joint = chain.joints()[static_cast<std::size_t>(i)];
      k_[i] = joint.stiffness;
      d_[i] = joint.damping;
      rest_[i] = joint.restAngle;
    }
    hasSprings_ = !k_.isZero(0) || !d_.isZero(0);
  }
  void place(const double* q, const double* qd) override {
    q_ = Eigen::Map<const Eigen::VectorXd>(q, q_.size());
    qd_ = Eigen::Map<const Eigen::VectorXd>(qd, qd_.size());
  }
  const double* accelerations() override {
    if (hasSprings_) tau_ = k_.cwiseProduct(rest_ - q_) - d_.cwiseProduct(qd_);
    return pinocchio::aba(model_, data_, q_, qd_, tau_, pinocchio::Convention::WORLD).data();
  }

 private:
  pinocchio::Model model_;
  pinocchio::Data data_;
  Eigen::VectorXd q_, qd_, tau_, k_, d_, rest_;
  bool hasSprings_ = false;
};

}  // namespace

std::unique_ptr<PinocchioChain> pinocchioChain(const Chain& chain) {
  return std::make_unique<InJointCoordinates>(chain);
}

const char* pinocchioVersion() {
  return PINOCCHIO_VERSION;
}

}  // namespace planar_chain::benchmarks
