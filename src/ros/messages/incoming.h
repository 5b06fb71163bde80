#pragma once

/// Input from other nodes: lists of bounded size, and checks of the numbers in messages and requests.
///
/// roscpp allocates a list as long as the message announces, up to 32 GB, before it reads the entries. The
/// type `Message_<Bounded<void>>` limits each list to 16 MiB in memory. roscpp drops a message that it cannot
/// read. `Received` accepts each one, with the reason why it is invalid.

#include <ros/advertise_service_options.h>
#include <ros/node_handle.h>
#include <ros/service_server.h>

#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "model/number_rule.h"
#include "planar_chain/fault.h"
#include "reading/names.h"

namespace planar_chain {

constexpr std::size_t mostBytesInAList = std::size_t{16} << 20;

struct TooLong : std::length_error {
  TooLong(std::size_t n, std::size_t most)
      : std::length_error("a list is too long"), entries(n), limit(most) {}
  std::size_t entries, limit;
};

/// std::allocator with that limit.
template <class T>
struct Bounded : std::allocator<T> {
  template <class Other>
  struct rebind {
    using other = Bounded<Other>;
  };
  Bounded() = default;
  template <class Other>
  Bounded(const Bounded<Other>& /*stateless*/) {}

  /// @throws TooLong above mostBytesInAList.
  T* allocate(std::size_t n) {
    constexpr std::size_t most = mostBytesInAList / sizeof(T);
    if (n > most) throw TooLong(n, most);
    return std::allocator<T>::allocate(n);
  }
};

template <class T>
std::vector<T> plain(const std::vector<T, Bounded<T>>& list) {
  return {list.begin(), list.end()};
}

/// A message of the usual type.
template <class Message, class In>
Message plainOf(const In& in) {
  Message message;
  ros::serialization::deserializeMessage(ros::serialization::serializeMessage(in), message);
  return message;
}

/// A message or request, or why it could not be read. In: such as JointTrajectory_<Bounded<void>>.
template <class In>
struct Received {
  std::optional<In> message;
  std::string expected, found;  ///< without a message
  std::size_t length = 0;       ///< of what was sent, bytes

  void read(ros::serialization::IStream& stream) {
    length = stream.getLength();
    try {
      stream.next(message.emplace());
      return;
    } catch (const TooLong& list) {
      expected = "at most " + std::to_string(list.limit) + " entries in a list";
      found = std::to_string(list.entries);
    } catch (const std::exception& problem) {
      expected = "a whole message";
      found = problem.what();
    }
    message.reset();
  }
};

struct Answer {
  bool success;
  std::string message;
};

/// Advertises a service under `node`. Request: such as SetStateRequest_; its lists are bounded. Every call of
/// `serve(request, response)` returns an Answer, and the response is sent with it.
template <class Service, template <class> class Request, class Serve>
ros::ServiceServer advertise(ros::NodeHandle& node, const char* name, Serve serve) {
  using Response = typename Service::Response;
  using In = Received<Request<Bounded<void>>>;
  using Spec = ros::ServiceSpec<In, Response>;
  ros::AdvertiseServiceOptions options;
  options.init<Service>(name, {});
  options.helper = boost::make_shared<ros::ServiceCallbackHelperT<Spec>>(
      typename Spec::CallbackType([serve, name](In& request, Response& response) {
        const Answer answer = request.message
                                  ? serve(*request.message, response)
                                  : Answer{false, toString(Fault{name, request.expected, request.found})};
        response.success = answer.success;
        response.message = answer.message;
        return true;
      }));
  return node.advertiseService(options);
}

/// Adds a fault if `value` is not finite. unit: such as "N m".
inline void checkFinite(std::vector<Fault>& faults, const std::string& path, const char* unit, double value) {
  if (std::isfinite(value)) return;
  faults.push_back({path, std::string("a finite number, ") + unit, toText(value)});
}

/// Adds a fault if `value` is not finite, or if products of it may overflow.
inline void checkFactor(std::vector<Fault>& faults, const std::string& path, const char* unit, double value) {
  if (isFactor(value)) return;
  faults.push_back({path, std::string(factorInWords(value)) + ", " + unit, toText(value)});
}

/// Adds a fault if `value` is not 0.
inline void checkZero(std::vector<Fault>& faults, const std::string& path, double value) {
  if (value == 0) return;
  faults.push_back({path, "0 (the motion is planar)", toText(value)});
}

/// Returns the index of `name`. Without one, adds a fault and returns −1. what, names, others: of oneOf().
inline int find(std::vector<Fault>& faults, const std::string& path, const char* what,
                const std::string& name, const Indices& names, const Indices* others = nullptr) {
  const auto found = names.find(name);
  if (found != names.end()) return found->second;
  faults.push_back({path, oneOf(what, name, names, others), quoted(name)});
  return -1;
}

/// Adds a fault if there is not one value per joint, and those of check() for each value. what, unit: such as
/// "angles", "rad".
inline void checkValues(std::vector<Fault>& faults, const std::string& path, const char* what,
                        const char* unit, const std::vector<double>& values, std::size_t joints,
                        decltype(checkFinite)& check = checkFinite) {
  if (values.size() != joints) {
    faults.push_back({path, std::to_string(joints) + " " + what + ", one per joint in chain order",
                      std::to_string(values.size())});
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    check(faults, path + "[" + std::to_string(i) + "]", unit, values[i]);
  }
}

}  // namespace planar_chain

// For roscpp, Received has the type of the message.

namespace ros {

namespace message_traits {
template <class In>
struct MD5Sum<planar_chain::Received<In>> : MD5Sum<In> {};
template <class In>
struct DataType<planar_chain::Received<In>> : DataType<In> {};
}  // namespace message_traits

namespace serialization {
template <class In>
struct Serializer<planar_chain::Received<In>> {
  static void read(IStream& stream, planar_chain::Received<In>& received) { received.read(stream); }
};
}  // namespace serialization

}  // namespace ros
