#pragma once

/// Lists in messages from outside. roscpp makes room for as many numbers as a message says it has, up to 32
/// GB, before it looks whether they came; in these the room has a bound.

#include <ros/advertise_service_options.h>
#include <ros/node_handle.h>
#include <ros/service_callback_helper.h>
#include <ros/service_server.h>
#include <ros/service_traits.h>

#include <cstddef>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

namespace planar_chain {

constexpr std::size_t mostBytesInAList = std::size_t{16} << 20;

/// std::allocator with that bound: a message type of roscpp takes it as `Message_<Bounded<void>>`, and is
/// refused by roscpp, which says why in the log.
template <class T>
struct Bounded : std::allocator<T> {
  template <class Other>
  struct rebind {
    using other = Bounded<Other>;
  };
  Bounded() = default;
  template <class Other>
  Bounded(const Bounded<Other>& /*stateless*/) {}

  /// @throws std::length_error
  T* allocate(std::size_t n) {
    if (n > mostBytesInAList / sizeof(T)) throw std::length_error("a list of more than 16 MiB");
    return std::allocator<T>::allocate(n);
  }
};

template <class T>
std::vector<T> plain(const std::vector<T, Bounded<T>>& list) {
  return {list.begin(), list.end()};
}

/// Advertises a service whose request is read as Request, the bounded kind of Service::Request.
/// `serve(const Request&, Service::Response&)` answers; a request is never left without an answer.
template <class Service, class Request, class Serve>
ros::ServiceServer advertise(ros::NodeHandle& node, const char* name, Serve serve) {
  using Response = typename Service::Response;
  using Spec = ros::ServiceSpec<Request, Response>;
  ros::AdvertiseServiceOptions options;
  options.service = name;
  options.md5sum = ros::service_traits::md5sum<Service>();
  options.datatype = ros::service_traits::datatype<Service>();
  options.req_datatype = ros::message_traits::datatype<typename Service::Request>();
  options.res_datatype = ros::message_traits::datatype<Response>();
  options.helper = boost::make_shared<ros::ServiceCallbackHelperT<Spec>>(
      typename Spec::CallbackType([serve = std::move(serve)](Request& request, Response& response) {
        serve(request, response);
        return true;
      }));
  return node.advertiseService(options);
}

}  // namespace planar_chain
