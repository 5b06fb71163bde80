#pragma once

/// The state of a simulation as ROS messages. A node publishes them, and `simulate --bag` writes them.

#include <geometry_msgs/WrenchStamped.h>
#include <planar_chain/LinkStates.h>
#include <planar_chain/SimStatus.h>
#include <ros/names.h>
#include <ros/publisher.h>
#include <ros/time.h>
#include <sensor_msgs/JointState.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "planar_chain/simulation.h"
#include "ros/messages/frames.h"
#include "ros/messages/ticks.h"
#include "ros/view/measurements.h"
#include "ros/view/views.h"

namespace planar_chain {

inline bool hasSubscribers(const ros::Publisher& topic) {
  return topic.getNumSubscribers() > 0;
}

/// The messages of two seconds, which are kept for a slow subscriber. rate: Hz.
inline std::uint32_t queueFor(double rate) {
  return static_cast<std::uint32_t>(std::max(10.0, std::ceil(2 * rate)));
}

struct Topic {
  std::string name;        ///< in full
  double rate;             ///< Hz
  std::uint32_t queue;     ///< messages
  bool isLatched = false;  ///< of the first tick alone

  bool isDue(const Ticks& ticks, long long tick) const {
    return isLatched ? tick == ticks.first : ticks.isDue(tick, rate);
  }
};

/// Each message is computed for the simulation's present state, and valid until the next call of the same
/// function. The caller may set header.seq. Only the constructor and baseWrench() allocate.
class Messages {
 public:
  /// node: the full name of the publishing node. The simulation must outlive this.
  /// @throws Refused for frame names that collide
  Messages(Simulation& simulation, const std::string& node, bool hasViews);

  const Frames& frames() const { return frames_; }

  sensor_msgs::JointState& jointStates(ros::Time stamp);
  LinkStates& linkStates(ros::Time stamp);
  /// The force and torque of the chain on its base, at the ground pin.
  geometry_msgs::WrenchStamped& baseWrench(ros::Time stamp);
  /// The force that holds the tip, on the tip. Its torque is 0.
  geometry_msgs::WrenchStamped& tipWrench(ros::Time stamp);
  /// The pose of each link that has a frame, in the frame before, or in the base frame for the first. If the
  /// base moves, a frame at its pin comes between base and first link. Between
  /// neighbours the origin is the outer pin of the link before, the rotation is q about z.
  tf2_msgs::TFMessage& transforms(ros::Time stamp);
  /// The pose of the base frame in the world: a roll of +π/2, so that the plane of motion is vertical. Then
  /// those of the IMUs on their links.
  tf2_msgs::TFMessage& staticTransforms(ros::Time stamp);
  /// The measurements of the sensors. Its functions allocate.
  Measurements& measurements() { return measurements_; }

  /// Calls visit(topic, make) for each topic that the scene publishes. make(stamp) returns a pointer to its
  /// message.
  template <class Visit>
  void forEach(Visit visit) {
    const PublishSettings& settings = simulation_.scene().publish;
    const std::uint32_t queue = queueFor(settings.rate);
    const std::string outer = ros::names::parentNamespace(node_);
    visit(Topic{ros::names::append(outer, "joint_states"), settings.rate, queue},
          [this](ros::Time stamp) { return &jointStates(stamp); });
    if (settings.tf) {
      visit(Topic{"/tf_static", 0, 1, true}, [this](ros::Time stamp) { return &staticTransforms(stamp); });
      visit(Topic{"/tf", settings.tfRate, queueFor(settings.tfRate)},
            [this](ros::Time stamp) { return &transforms(stamp); });
    }
    if (views_ || simulation_.scene().base) {
      visit(Topic{node_ + "/base_wrench", settings.rate, queue},
            [this](ros::Time stamp) { return &baseWrench(stamp); });
    }
    if (simulation_.scene().tip) {
      visit(Topic{node_ + "/tip_wrench", settings.rate, queue},
            [this](ros::Time stamp) { return &tipWrench(stamp); });
    }
    if (views_) {
      views_->forEach([&](const std::string& name, auto make) {
        visit(Topic{node_ + "/view/" + name, settings.tfRate, 2}, make);
      });
    }
    if (settings.linkStates) {
      visit(Topic{node_ + "/link_states", settings.rate, queue},
            [this](ros::Time stamp) { return &linkStates(stamp); });
    }
  }

 private:
  Simulation& simulation_;
  std::string node_;
  Frames frames_;
  sensor_msgs::JointState jointStates_;
  LinkStates linkStates_;
  geometry_msgs::WrenchStamped baseWrench_, tipWrench_;
  tf2_msgs::TFMessage transforms_, staticTransforms_;
  Measurements measurements_;
  std::vector<LinkMotion> motions_;
  std::vector<int> framed_;  ///< the link of each transform
  std::optional<Views> views_;
};

/// SimStatus::standstill after a fault.
inline constexpr const char* standstillByFault = "the integration has failed";

/// Sets the fields of `status` that the simulation determines. The others stay as they are. Before the first
/// step, the method is that of a status before, or else found by a copy of the simulation.
void describe(Simulation& simulation, SimStatus& status);

}  // namespace planar_chain
