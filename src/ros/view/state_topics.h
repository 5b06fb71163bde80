#pragma once

/// The topics that show the state of a tick. A node publishes them, and `simulate --bag` writes them.

#include <ros/names.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "ros/messages/messages.h"
#include "ros/messages/pace.h"
#include "ros/view/views.h"

namespace planar_chain {

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

class StateTopics {
 public:
  /// node: the full name of the publishing node. The simulation must outlive this.
  StateTopics(Simulation& simulation, const Frames& frames, const std::string& node, bool hasViews)
      : simulation_(simulation), node_(node), messages_(simulation.scene(), frames) {
    if (hasViews) views_.emplace(simulation, frames);
  }

  sensor_msgs::JointState& jointStates(ros::Time stamp) { return messages_.jointStates(simulation_, stamp); }

  /// Calls visit(topic, make) for each topic of the scene. make(stamp) computes the message of the present
  /// state. The message is valid until the next call.
  template <class Visit>
  void forEach(Visit visit) {
    const PublishSettings& settings = simulation_.scene().publish;
    visit(
        Topic{ros::names::append(ros::names::parentNamespace(node_), "joint_states"), settings.rate,
              queueFor(settings.rate)},
        [this](ros::Time stamp) -> auto& { return jointStates(stamp); });
    if (settings.tf) {
      visit(
          Topic{"/tf_static", 0, 1, true}, [this](ros::Time stamp) -> auto& {
            return messages_.baseInWorld(stamp);
          });
      visit(
          Topic{"/tf", settings.tfRate, queueFor(settings.tfRate)}, [this](ros::Time stamp) -> auto& {
            return messages_.transforms(simulation_, stamp);
          });
    }
    if (views_) {
      views_->forEach([&](const std::string& name, auto make) {
        visit(Topic{node_ + "/view/" + name, settings.tfRate, 2}, make);
      });
    }
    if (settings.linkStates) {
      visit(
          Topic{node_ + "/link_states", settings.rate, queueFor(settings.rate)},
          [this](ros::Time stamp) -> auto& { return messages_.linkStates(simulation_, stamp); });
    }
  }

 private:
  Simulation& simulation_;
  std::string node_;
  Messages messages_;
  std::optional<Views> views_;
};

}  // namespace planar_chain
