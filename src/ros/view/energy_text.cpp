#include "ros/view/energy_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace planar_chain {

namespace {

using visualization_msgs::Marker;

// In units of half the height of the view.
constexpr double textSize = 0.055, textAside = 1.24, textUnder = 0.97;
constexpr double longestNumber = 5.3;  // width of a number with its unit, sizes of the text
constexpr double negligible = 1e-12;   // share of the reference: less energy (J) reads 0
constexpr int digits = 4;              // of an energy as large as the reference

/// A label and its width in rviz's font, Liberation Sans, in units of 1/28 of the text's size.
struct Label {
  const char* text;
  int width;
};
constexpr double widthUnits = 28;
constexpr int spaceWidth = 16;
constexpr std::array<Label, 6> labels{{{"time", 45},
                                       {"kinetic", 67},
                                       {"potential", 89},
                                       {"supplied", 87},
                                       {"dissipated", 106},
                                       {"balance", 82}}};

/// The width of a number with its unit, in the same units.
int widthOf(const std::string& number) {
  int width = 0;
  for (const char c : number) {
    switch (c) {
      case '.':
        width += 7;
        break;
      case '-':
        width += 8;
        break;
      case '+':
        width += 14;
        break;
      case ' ':
        width += spaceWidth;
        break;
      case 'J':
      case 's':
        width += 12;
        break;
      default:
        width += 13;
    }
  }
  return width;
}

/// Text of a number with as many decimals as give `digits` for the reference.
std::string withDecimalsOf(double reference, double number) {
  const int power = reference > 0 ? static_cast<int>(std::floor(std::log10(reference))) : 0;
  std::array<char, 400> text{};
  if (power < -digits || power > 2 * digits) {
    std::snprintf(text.data(), text.size(), "%.*e", digits - 1, number);
  } else {
    std::snprintf(text.data(), text.size(), "%.*f", std::max(0, digits - 1 - power), number);
  }
  return text.data();
}

}  // namespace

EnergyText::EnergyText(const Extent& view, const std::string& frame, double reference)
    : reference_(reference), size_(textSize * view.half) {
  const double left = view.centre.x - textAside * view.half;
  middle_ = left + longestNumber * size_;
  for (std::size_t line = 0; line < labels.size(); ++line) {
    Marker marker;
    marker.header.frame_id = frame;
    marker.frame_locked = true;
    marker.ns = "energy";
    marker.type = Marker::TEXT_VIEW_FACING;
    marker.id = static_cast<int>(line);
    marker.pose.position.y =
        view.centre.y - textUnder * view.half + (static_cast<double>(labels.size() - line) - 0.5) * size_;
    marker.pose.orientation.w = 1;
    marker.scale.z = size_;
    marker.color.r = 0.85F, marker.color.g = 0.88F, marker.color.b = 0.92F, marker.color.a = 1;
    message_.markers.push_back(marker);
  }
}

/// Numbers end, and labels begin, below each other. rviz centres each text on its position.
void EnergyText::put(std::size_t line, const std::string& number) {
  Marker& marker = message_.markers[line];
  const int before = widthOf(number), behind = spaceWidth + labels[line].width;
  marker.text = number + " " + labels[line].text;
  marker.pose.position.x = middle_ + (behind - before) / widthUnits / 2 * size_;
}

visualization_msgs::MarkerArray& EnergyText::write(double time, const EnergyBalance& balance,
                                                   ros::Time stamp) {
  const auto shown = [this](double joules) {
    return std::fabs(joules) < negligible * reference_ ? 0 : joules;
  };
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.2f s", time);
  put(0, text.data());
  std::size_t line = 0;
  for (const double joules :
       {balance.now.kinetic, balance.now.potential, balance.supplied, balance.dissipated}) {
    put(++line, withDecimalsOf(reference_, shown(joules)) + " J");
  }
  std::snprintf(text.data(), text.size(), "%.1e J", shown(balance.residual));
  put(++line, text.data());
  for (Marker& marker : message_.markers) marker.header.stamp = stamp;
  return message_;
}

}  // namespace planar_chain
