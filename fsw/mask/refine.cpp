#include "mask/refine.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "mask/grown.hpp"
#include "mask/outline.hpp"

namespace polhode {
namespace {

// What a network counts that is sure. The outline counts 0.3, log-odds up to 0.23, the map up to
// 0.25 and the appearance up to 0.6: it outweighs each, and by a little the first three together.
constexpr double kShare = 0.9;

void as_input(const cv::Mat& levels, cv::Mat* part, cv::Mat* input) {
  const cv::Size size(MaskNetwork::kSide_px, MaskNetwork::kSide_px);
  cv::resize(levels, *part, size, 0.0, 0.0, cv::INTER_LINEAR);
  part->convertTo(*input, CV_32FC1, 1.0 / 255.0);
}

}  // namespace

void refine_unary_cost(const cv::Mat& picture,
                       const cv::Mat& outline,
                       const MaskNetwork& network,
                       int step,
                       RefineScratch* s,
                       cv::Mat* unary_cost) {
  constexpr double kRounding = 1e-6;  // a network's last layer in floats: 8 units in the last place
  cv::Rect box = cv::boundingRect(outline);
  if (network.ask == nullptr || box.empty()) {
    return;
  }
  // A quarter: chosen, as networks need what is around a target. At least what outlines are off by.
  const int margin = std::max(kOutlineOff_px, std::max(box.width, box.height) / 4);
  box = grown(box, margin) & cv::Rect(0, 0, picture.cols, picture.rows);
  as_input(picture(box), &s->part, &s->gray);
  as_input(outline(box), &s->part, &s->outline);
  s->target.create(s->gray.size(), CV_32FC1);
  if (!network.ask(
          network.context, s->gray.ptr<float>(), s->outline.ptr<float>(), s->target.ptr<float>()) ||
      !cv::checkRange(s->target, true, nullptr, 0.0, 1.0 + kRounding)) {
    return;
  }
  cv::Mat part = (*unary_cost)(coarser(box, step));
  cv::resize(s->target, s->full, part.size(), 0.0, 0.0, cv::INTER_LINEAR);
  s->full.convertTo(s->full, CV_32FC1, 2.0 * kShare, -kShare);
  cv::add(part, s->full, part);
}

}  // namespace polhode
