#include "report/benchmark/mujoco_model.h"

#include <algorithm>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>

namespace planar_chain::benchmarks {

namespace {

constexpr int linksPerFile = 50;  // its reader of XML takes no more than 100 nested elements

std::string fileName(int k) {
  return std::to_string(k) + ".xml";
}

/// Links from `first` on, each within the one before; what does not fit is included.
std::string bodiesOf(const Chain& chain, int first) {
  const int end = std::min(chain.size(), first + linksPerFile);
  std::ostringstream xml;
  xml.precision(17);
  for (int i = first; i < end; ++i) {
    const Link& link = chain.links()[static_cast<std::size_t>(i)];
    const Joint& joint = chain.joints()[static_cast<std::size_t>(i)];
    const Vec2d at = i > 0 ? chain.links()[static_cast<std::size_t>(i - 1)].pin : Vec2d{};
    const double inertia = joint.isPrismatic ? 1 : link.inertia;  // a slide does not turn; it must have some
    xml << "<body name='" << i << "' pos='" << at.x << ' ' << at.y << " 0'><joint ";
    if (joint.isPrismatic) {
      xml << "type='slide' axis='" << joint.axis.x << ' ' << joint.axis.y << " 0";
    } else {
      xml << "type='hinge' axis='0 0 1";
    }
    xml << "' stiffness='" << joint.stiffness << "' damping='" << joint.damping << "' springref='"
        << joint.restAngle << "'/><inertial pos='" << link.com.x << ' ' << link.com.y << " 0' mass='"
        << link.mass << "' diaginertia='" << inertia << ' ' << inertia << ' ' << inertia << "'/>";
  }
  if (end < chain.size()) xml << "<include file='" << fileName(end / linksPerFile) << "'/>";
  for (int i = first; i < end; ++i) xml << "</body>";
  return xml.str();
}

void write(mjVFS& files, const std::string& name, const std::string& text) {
#if mjVERSION_HEADER >= 4000000
  mj_addBufferVFS(&files, name.c_str(), text.data(), static_cast<int>(text.size()));
#else
  mj_makeEmptyFileVFS(&files, name.c_str(), static_cast<int>(text.size()));
  text.copy(static_cast<char*>(files.filedata[mj_findFileVFS(&files, name.c_str())]), text.size());
#endif
}

}  // namespace

mjModel* modelOf(const Chain& chain, bool holdsTip) {
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  std::ostringstream root;
  root.precision(17);
  root << "<mujoco><compiler angle='radian'/><option gravity='" << chain.gravity().x << ' '
       << chain.gravity().y << " 0'/><worldbody>" << bodiesOf(chain, 0) << "</worldbody>";
  if (holdsTip) {
    const Vec2d pin = chain.links().back().pin;
    root << "<equality><connect body1='" << chain.size() - 1 << "' anchor='" << pin.x << ' ' << pin.y
         << " 0'/></equality>";
  }
  root << "</mujoco>";
  write(*files, fileName(0), root.str());
  for (int i = linksPerFile; i < chain.size(); i += linksPerFile) {
    write(*files, fileName(i / linksPerFile), "<mujoco>" + bodiesOf(chain, i) + "</mujoco>");
  }
  char error[500] = "";
  mjModel* model = mj_loadXML(fileName(0).c_str(), files.get(), error, sizeof error);
  mj_deleteVFS(files.get());
  if (!model) throw std::runtime_error(error);
  return model;
}

}  // namespace planar_chain::benchmarks
