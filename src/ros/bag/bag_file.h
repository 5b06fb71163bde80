#pragma once

/// Writes a bag, format 2.0 (http://wiki.ros.org/Bags/Format/2.0), in chunks that are not compressed.
///
/// Not by rosbag::Bag: it asks the file for its end at every message, which takes longer than to simulate,
/// serialize and write it here. What is written is a function of what is given: no clock is read.

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <ros/time.h>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

namespace planar_chain {

class BagFile {
 public:
  /// @throws std::runtime_error when the file cannot be opened
  explicit BagFile(const std::string& path);
  /// Without close() the bag has no index: `rosbag reindex` makes one.
  ~BagFile();
  BagFile(const BagFile&) = delete;
  BagFile& operator=(const BagFile&) = delete;

  /// A publisher of the node `caller`. It is in the bag once it has written a message.
  /// @returns its number, for write()
  template <class Message>
  std::uint32_t connect(const std::string& topic, const std::string& caller, bool isLatching = false) {
    namespace traits = ros::message_traits;
    return connect({topic, caller, isLatching, traits::datatype<Message>(), traits::md5sum<Message>(),
                    traits::definition<Message>(), 0});
  }

  /// As every publisher does, it puts its own count into header.seq, where there is one.
  /// @throws std::runtime_error when the disk is full or the like
  template <class Message>
  void write(std::uint32_t connection, ros::Time time, const Message& message) {
    const std::uint32_t length = ros::serialization::serializationLength(message);
    const std::uint32_t count = connections_[connection].messages;
    std::uint8_t* const room = roomFor(connection, time, length);
    ros::serialization::OStream stream(room, length);
    ros::serialization::serialize(stream, message);
    // The header comes first, and seq first in it.
    if (ros::message_traits::hasHeader<Message>()) std::memcpy(room, &count, sizeof count);
  }

  /// Writes the index: the bag is whole.
  /// @throws std::runtime_error as write()
  void close();

 private:
  struct Connection {
    std::string topic, caller;
    bool isLatching;
    std::string type, md5sum, definition;
    std::uint32_t messages;  ///< in the bag
  };
  struct IndexEntry {
    ros::Time time;
    std::uint32_t offset;  ///< in the chunk
  };
  struct ChunkInfo {
    std::uint64_t position;
    ros::Time first, last;
    std::vector<std::uint32_t> counts;  ///< of messages, by connection
  };

  std::uint32_t connect(Connection connection);
  /// Begins a message in the chunk. @returns where its `length` bytes go
  std::uint8_t* roomFor(std::uint32_t connection, ros::Time time, std::uint32_t length);
  void appendConnection(std::string& to, std::uint32_t number) const;
  void writeHeader(std::uint64_t indexPosition);
  void writeChunk();
  void put(const std::string& bytes);
  [[noreturn]] void fail() const;

  std::string path_;
  std::FILE* file_;
  std::uint64_t position_ = 0;
  std::vector<Connection> connections_;
  std::vector<ChunkInfo> chunks_;
  // The chunk that grows, and the index of its messages by connection.
  std::string chunk_;
  std::vector<std::vector<IndexEntry>> index_;
};

}  // namespace planar_chain
