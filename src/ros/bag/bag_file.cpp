#include "ros/bag/bag_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace planar_chain {

namespace {

constexpr std::size_t chunkSize = 768 * 1024;  // as rosbag has it
constexpr std::uint32_t headerSize = 4096;     // of the bag's own record, padded: it is written twice

enum class Op : std::uint8_t { message = 2, bag = 3, index = 4, chunk = 5, chunkInfo = 6, connection = 7 };

/// Numbers are little endian, as in this machine's memory and in ROS's messages.
template <class Number>
void append(std::string& to, Number number) {
  to.append(reinterpret_cast<const char*>(&number), sizeof number);
}

void append(std::string& to, ros::Time time) {
  append(to, time.sec);
  append(to, time.nsec);
}

/// A list of name=value, each with its length before it, and the length of all before that.
class Fields {
 public:
  explicit Fields(std::string& to) : to_(to), begin_(to.size()) { append(to_, std::uint32_t{0}); }
  Fields(std::string& to, Op op) : Fields(to) { add("op", op); }
  ~Fields() {
    const auto length = static_cast<std::uint32_t>(to_.size() - begin_ - sizeof(std::uint32_t));
    std::memcpy(&to_[begin_], &length, sizeof length);
  }
  Fields(const Fields&) = delete;
  Fields& operator=(const Fields&) = delete;

  template <class Number>
  Fields& add(const char* name, Number value) {
    begin(name, sizeof value);
    append(to_, value);
    return *this;
  }
  Fields& add(const char* name, const std::string& value) {
    begin(name, value.size());
    to_ += value;
    return *this;
  }

 private:
  void begin(const char* name, std::size_t valueSize) {
    append(to_, static_cast<std::uint32_t>(std::strlen(name) + 1 + valueSize));
    to_ += name;
    to_ += '=';
  }

  std::string& to_;
  std::size_t begin_;
};

}  // namespace

BagFile::BagFile(const std::string& path) : path_(path), file_(std::fopen(path.c_str(), "wb")) {
  if (!file_) fail();
  put("#ROSBAG V2.0\n");
  writeHeader(0);
}

BagFile::~BagFile() {
  if (file_) std::fclose(file_);
}

std::uint32_t BagFile::connect(Connection connection) {
  connections_.push_back(std::move(connection));
  index_.emplace_back();
  return static_cast<std::uint32_t>(connections_.size() - 1);
}

std::uint8_t* BagFile::roomFor(std::uint32_t connection, ros::Time time, std::uint32_t length) {
  if (chunk_.size() >= chunkSize) writeChunk();
  if (chunk_.empty()) chunks_.push_back({position_, time, time, {}});
  ChunkInfo& info = chunks_.back();
  info.first = std::min(info.first, time);
  info.last = std::max(info.last, time);

  if (connections_[connection].messages++ == 0) appendConnection(chunk_, connection);
  index_[connection].push_back({time, static_cast<std::uint32_t>(chunk_.size())});
  Fields(chunk_, Op::message).add("conn", connection).add("time", time);
  append(chunk_, length);
  const std::size_t begin = chunk_.size();
  chunk_.resize(begin + length);
  return reinterpret_cast<std::uint8_t*>(&chunk_[begin]);
}

void BagFile::appendConnection(std::string& to, std::uint32_t number) const {
  const Connection& connection = connections_[number];
  Fields(to, Op::connection).add("conn", number).add("topic", connection.topic);
  std::string publisher;
  Fields(publisher)
      .add("callerid", connection.caller)
      .add("latching", std::string(connection.isLatching ? "1" : "0"))
      .add("md5sum", connection.md5sum)
      .add("message_definition", connection.definition)
      .add("topic", connection.topic)
      .add("type", connection.type);
  to += publisher;  // its own length stands before it, as that of every record's data does
}

void BagFile::writeHeader(std::uint64_t indexPosition) {
  const auto used = std::count_if(connections_.begin(), connections_.end(),
                                  [](const Connection& c) { return c.messages > 0; });
  std::string record;
  Fields(record, Op::bag)
      .add("chunk_count", static_cast<std::uint32_t>(chunks_.size()))
      .add("conn_count", static_cast<std::uint32_t>(used))
      .add("index_pos", indexPosition);
  const auto padding = headerSize - static_cast<std::uint32_t>(record.size() - sizeof(std::uint32_t));
  append(record, padding);
  record.append(padding, ' ');
  put(record);
}

void BagFile::writeChunk() {
  std::string record;
  const auto size = static_cast<std::uint32_t>(chunk_.size());
  Fields(record, Op::chunk).add("compression", std::string("none")).add("size", size);
  append(record, size);
  put(record);
  put(chunk_);
  chunk_.clear();

  std::vector<std::uint32_t>& counts = chunks_.back().counts;
  record.clear();
  for (std::uint32_t number = 0; number < index_.size(); ++number) {
    std::vector<IndexEntry>& entries = index_[number];
    const auto count = static_cast<std::uint32_t>(entries.size());
    counts.push_back(count);
    if (count == 0) continue;
    Fields(record, Op::index).add("conn", number).add("count", count).add("ver", std::uint32_t{1});
    append(record, static_cast<std::uint32_t>(count * (sizeof(std::uint64_t) + sizeof(std::uint32_t))));
    for (const IndexEntry& entry : entries) {
      append(record, entry.time);
      append(record, entry.offset);
    }
    entries.clear();
  }
  put(record);
}

void BagFile::close() {
  if (!chunk_.empty()) writeChunk();
  const std::uint64_t indexPosition = position_;
  std::string records;
  for (std::uint32_t number = 0; number < connections_.size(); ++number) {
    if (connections_[number].messages > 0) appendConnection(records, number);
  }
  for (const ChunkInfo& chunk : chunks_) {
    std::string counts;
    std::uint32_t used = 0;
    for (std::uint32_t number = 0; number < chunk.counts.size(); ++number) {
      if (chunk.counts[number] == 0) continue;
      append(counts, number);
      append(counts, chunk.counts[number]);
      ++used;
    }
    Fields(records, Op::chunkInfo)
        .add("chunk_pos", chunk.position)
        .add("count", used)
        .add("end_time", chunk.last)
        .add("start_time", chunk.first)
        .add("ver", std::uint32_t{1});
    append(records, static_cast<std::uint32_t>(counts.size()));
    records += counts;
  }
  put(records);

  if (std::fseek(file_, static_cast<long>(std::strlen("#ROSBAG V2.0\n")), SEEK_SET) != 0) fail();
  writeHeader(indexPosition);
  if (std::fclose(std::exchange(file_, nullptr)) != 0) fail();
}

void BagFile::put(const std::string& bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) fail();
  position_ += bytes.size();
}

void BagFile::fail() const {
  throw std::runtime_error("cannot write " + path_ + ": " + std::strerror(errno));
}

}  // namespace planar_chain
