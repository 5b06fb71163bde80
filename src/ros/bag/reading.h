#pragma once

/// The answer of the child process that reads a bag: the commands or, if they are refused, the reason.

#include <ros/serialization.h>

#include <cstdint>
#include <string>
#include <vector>

#include "planar_chain/fault.h"
#include "ros/bag/recorded_commands.h"

namespace planar_chain {

struct Reading {
  RecordedCommands recorded;
  std::vector<Fault> faults;
};

}  // namespace planar_chain

namespace ros::serialization {

template <>
struct Serializer<planar_chain::Fault> {
  template <class Stream, class Of>
  static void allInOne(Stream& stream, Of fault) {
    stream.next(fault.path);
    stream.next(fault.expected);
    stream.next(fault.found);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

template <>
struct Serializer<planar_chain::Reading> {
  template <class Stream, class Of>
  static void allInOne(Stream& stream, Of reading) {
    stream.next(reading.recorded.node);
    stream.next(reading.recorded.commands);
    stream.next(reading.recorded.lastTick);
    stream.next(reading.recorded.scene);
    stream.next(reading.recorded.ticks);
    stream.next(reading.recorded.digests);
    stream.next(reading.faults);
  }
  ROS_DECLARE_ALLINONE_SERIALIZER
};

}  // namespace ros::serialization

namespace planar_chain {

inline std::string inBytes(const Reading& reading) {
  std::string bytes(ros::serialization::serializationLength(reading), '\0');
  ros::serialization::OStream stream(reinterpret_cast<std::uint8_t*>(bytes.data()),
                                     static_cast<std::uint32_t>(bytes.size()));
  stream.next(reading);
  return bytes;
}

inline Reading ofBytes(std::string bytes) {
  Reading reading;
  ros::serialization::IStream stream(reinterpret_cast<std::uint8_t*>(bytes.data()),
                                     static_cast<std::uint32_t>(bytes.size()));
  stream.next(reading);
  return reading;
}

}  // namespace planar_chain
