/// Preloaded into the node, where it stands before roscpp's own: writes down the order in which messages are
/// published, the topic of each and its first bytes, as lines of the file $PUBLISHED.

#include <dlfcn.h>
#include <ros/publisher.h>

#include <cstdio>
#include <cstdlib>

namespace ros {

void Publisher::publish(const boost::function<SerializedMessage()>& serialize,
                        SerializedMessage& message) const {
  using Publish = void (*)(const Publisher*, const boost::function<SerializedMessage()>&, SerializedMessage&);
  static const auto roscpps = reinterpret_cast<Publish>(
      dlsym(RTLD_NEXT, "_ZNK3ros9Publisher7publishERKN5boost8functionIFNS_17SerializedMessageEvEEERS3_"));
  static std::FILE* const file = std::fopen(std::getenv("PUBLISHED"), "w");

  const SerializedMessage whole = serialize();
  const std::size_t begin = static_cast<std::size_t>(whole.message_start - whole.buf.get()),
                    most = begin + 16;
  std::fprintf(file, "%s ", getTopic().c_str());
  for (std::size_t i = begin; i < whole.num_bytes && i < most; ++i) std::fprintf(file, "%02x", whole.buf[i]);
  std::fputs("\n", file);
  std::fflush(file);
  roscpps(this, serialize, message);
}

}  // namespace ros
