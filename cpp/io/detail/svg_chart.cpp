#include "svg_chart.hpp"

#include <algorithm>

#include "detail/number_text.hpp"

namespace graspctx::detail {

namespace {

constexpr double width_px = 430, height_px = 300;
constexpr double left_px = 52, right_px = 14, top_px = 12, bottom_px = 44;
constexpr double plot_width_px = width_px - left_px - right_px;
constexpr double plot_height_px = height_px - top_px - bottom_px;

std::string px(double value) {
  return decimal_text(value, 1);
}

std::string attribute(const char* name, const std::string& value) {
  return std::string(" ") + name + "=\"" + value + "\"";
}

std::string text_element(const char* css_class, double x, double y, const std::string& text,
                         const std::string& more = "") {
  return "<text" + attribute("class", css_class) + attribute("x", px(x)) + attribute("y", px(y)) + more +
         ">" + escaped(text) + "</text>\n";
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\'':
        result += "&#39;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

const char* SvgChart::style() {
  return "svg { width: 430px; max-width: 100%; height: auto; }\n"
         "svg text { font: 12px sans-serif; fill: #222; }\n"
         ".middle { text-anchor: middle; }\n.end { text-anchor: end; }\n"
         ".grid { stroke: #ddd; }\n.frame { fill: none; stroke: #555; }\n"
         ".curve { fill: none; stroke: #1f5fa8; stroke-width: 2; }\n"
         ".reference { fill: none; stroke: #666; stroke-dasharray: 4 4; }\n"
         ".interval { stroke: #1f5fa8; stroke-width: 1.5; }\n"
         ".point { fill: #1f5fa8; }\n.hit { fill: #a9cbea; }\n.miss { fill: #f3cfa6; }\n";
}

SvgChart::SvgChart(const std::string& title, const std::string& x_label, const std::string& y_label,
                   double x_max)
    : x_max_(x_max) {
  svg_ = "<svg role=\"img\"" + attribute("viewBox", "0 0 " + px(width_px) + " " + px(height_px)) + ">\n" +
         "<title>" + escaped(title) + "</title>\n";
  for (int i = 0; i <= 5; ++i) {
    const double y = i / 5.0;
    line({{0, y}, {x_max, y}}, "grid");
    svg_ += text_element("end", left_px - 6, top_px + plot_height_px * (1 - y) + 4, decimal_text(y, 1));
  }
  svg_ += text_element("middle", left_px + plot_width_px / 2, height_px - 6, x_label);
  svg_ += text_element(
      "middle", 0, 0, y_label,
      attribute("transform", "translate(14 " + px(top_px + plot_height_px / 2) + ") rotate(-90)"));
}

std::string SvgChart::x_text(double x) const {
  return px(left_px + plot_width_px * x / x_max_);
}

std::string SvgChart::y_text(double y) const {
  return px(top_px + plot_height_px * (1 - y));
}

void SvgChart::tick(double x, const std::string& text) {
  svg_ += text_element("middle", left_px + plot_width_px * x / x_max_, height_px - bottom_px + 16, text);
}

void SvgChart::unit_ticks() {
  for (int i = 0; i <= 5; ++i) tick(i / 5.0, decimal_text(i / 5.0, 1));
}

void SvgChart::line(const Points& points, const char* css_class) {
  std::string path;
  for (const auto& [x, y] : points) path += (path.empty() ? "M" : " L") + x_text(x) + " " + y_text(y);
  svg_ += "<path" + attribute("class", css_class) + attribute("d", path) + "/>\n";
}

void SvgChart::band(double x, double low, double high) {
  line({{x, low}, {x, high}}, "interval");
}

void SvgChart::dot(double x, double y, const char* css_class) {
  svg_ += "<circle" + attribute("class", css_class) + attribute("cx", x_text(x)) +
          attribute("cy", y_text(y)) + " r=\"4\"/>\n";
}

void SvgChart::bar(double x_low, double x_high, double y_low, double y_high, const char* css_class) {
  svg_ += "<rect" + attribute("class", css_class) + attribute("x", x_text(x_low)) +
          attribute("y", y_text(y_high)) + attribute("width", px(plot_width_px * (x_high - x_low) / x_max_)) +
          attribute("height", px(plot_height_px * (y_high - y_low))) + "/>\n";
}

void SvgChart::text(double x, double y, const std::string& text) {
  svg_ +=
      text_element("middle", left_px + plot_width_px * x / x_max_, top_px + plot_height_px * (1 - y), text);
}

std::string SvgChart::finish() {
  bar(0, x_max_, 0, 1, "frame");
  return svg_ + "</svg>\n";
}

}  // namespace graspctx::detail
