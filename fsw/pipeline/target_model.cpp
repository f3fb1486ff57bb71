#include "pipeline/target_model.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <bit>
#include <bitset>
#include <cstring>
#include <type_traits>

#include "base/assert.hpp"
#include "base/validity.hpp"
#include "map/validity.hpp"
#include "motion/soundness.hpp"
#include "pipeline/reset.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

/// Unsigned integer of a number's width.
template <typename T>
using BitsOf = std::conditional_t<sizeof(T) == 8,
                                  std::uint64_t,
                                  std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint8_t>>;

/// Writes numbers in sequence, least significant byte first on every machine.
class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> out) : out_(out) {}
  template <typename T>
  void number(const T& value) {
    POLHODE_ASSERT(used_ + sizeof(T) <= out_.size(), used_);
    const auto bits = std::bit_cast<BitsOf<T>>(value);
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      out_[used_++] = static_cast<std::uint8_t>(bits >> 8 * i);
    }
  }
  [[nodiscard]] std::size_t used() const { return used_; }

 private:
  std::span<std::uint8_t> out_;
  std::size_t used_ = 0;
};

/// Missing bytes read as zero and clear good().
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> octets) : octets_(octets) {}
  template <typename T>
  void number(T& value) {
    good_ = good_ && octets_.size() >= sizeof(T);
    BitsOf<T> bits = 0;
    for (std::size_t i = 0; good_ && i < sizeof(T); ++i) {
      bits = static_cast<BitsOf<T>>(bits | static_cast<BitsOf<T>>(octets_[i]) << 8 * i);
    }
    octets_ = good_ ? octets_.subspan(sizeof(T)) : octets_;
    if constexpr (std::is_same_v<T, bool>) {
      good_ = good_ && bits <= 1;
      value = bits == 1;
    } else {
      value = std::bit_cast<T>(bits);
    }
  }
  [[nodiscard]] bool good() const { return good_; }
  [[nodiscard]] bool at_end() const { return octets_.empty(); }

 private:
  std::span<const std::uint8_t> octets_;
  bool good_ = true;
};

/// Numbers, and arrays and matrices of them; the same for both directions.
template <typename Archive, typename... Values>
void put(Archive* a, Values&... values) {
  const auto one = [&](auto& value) {
    if constexpr (std::is_arithmetic_v<std::remove_reference_t<decltype(value)>>) {
      a->number(value);
    } else {
      for (std::size_t i = 0; i < static_cast<std::size_t>(value.size()); ++i) {
        a->number(value.data()[i]);
      }
    }
  };
  (one(values), ...);
}

/// Header before the tables.
struct Head {
  TargetModelFacts facts;
  MapDrift drift;
};

template <typename Archive, typename H>
void put_head(Archive* a, H& head) {
  auto& f = head.facts;
  put(a, f.keyframes, f.landmarks, f.radius_mu, f.scale_known, f.metres_per_mu, f.scale_sigma);
  auto& body = f.body;
  put(a, body.known, body.shape, body.shape_sigma, body.mass_centre_T, body.mass_centre_sigma);
  auto& d = head.drift;
  put(a, d.walk, d.fixed, d.reanchoring, d.reanchored_keyframe, d.R_first_CT);
  put(a, d.initial_turn_sigma, d.initial_sigma_mu, d.initial_turn_rad, d.turn_rad);
}

/// @param created, seen  keyframes, by their rank in age.
template <typename Archive, typename L, typename Rank>
void put_landmark(Archive* a, L& landmark, Rank& created, Rank& seen) {
  put(a, landmark.p_T, landmark.found, landmark.predicted, created, seen);
}

/// @param age_ns  before the newest keyframe.
template <typename Archive, typename K>
void put_keyframe(Archive* a, K& keyframe, std::int64_t& age_ns, std::uint32_t& features) {
  put(a, keyframe.R_IC, keyframe.pose.R_CT, keyframe.pose.p_CT, age_ns, features);
}

/// A feature with a landmark. Lengths in the image plane z = 1, which no camera changes.
struct StoredFeature {
  std::uint32_t landmark = 0;  ///< its place among those stored
  Eigen::Vector2d normalised = Eigen::Vector2d::Zero();
  double sigma_normalised = 0.0;
  double scale_normalised = 0.0;
  float angle_rad = 0.0F;
  Descriptor descriptor{};
};

template <typename Archive, typename F>
void put_feature(Archive* a, F& f) {
  put(a, f.landmark, f.normalised, f.sigma_normalised, f.scale_normalised, f.angle_rad);
  put(a, f.descriptor);
}

constexpr std::size_t kHeadOctetsMax = sizeof(Head);
constexpr std::size_t kLandmarkOctetsMax = sizeof(Landmark);
constexpr std::size_t kKeyframeOctetsMax = sizeof(Keyframe) - sizeof(Features);

StoredFeature stored(const Feature& feature, std::uint32_t landmark, double focal_px) {
  return {.landmark = landmark,
          .normalised = feature.normalised,
          .sigma_normalised = static_cast<double>(feature.sigma_px) / focal_px,
          .scale_normalised = static_cast<double>(feature.scale_px) / focal_px,
          .angle_rad = feature.angle_rad,
          .descriptor = feature.descriptor};
}

/// The feature in this camera's pixels. It may lie outside the image: the range was another one.
Feature feature_of(const StoredFeature& stored, const CameraModel& camera) {
  const Eigen::Vector2d pixel = project_px(camera, stored.normalised);
  return {.normalised = stored.normalised,
          .u_px = static_cast<float>(pixel.x()),
          .v_px = static_cast<float>(pixel.y()),
          .sigma_px = static_cast<float>(stored.sigma_normalised * camera.focal_px()),
          .scale_px = static_cast<float>(stored.scale_normalised * camera.focal_px()),
          .angle_rad = stored.angle_rad,
          .descriptor = stored.descriptor};
}

KnownBody body_of(const RigidModel& model) {
  KnownBody body;
  if (model.accepted() && model.translation_known) {
    body.known = true;
    body.shape = model.shape;
    body.shape_sigma = model.covariance.diagonal()
                           .segment<kShapeNumbers>(kRotationUnknowns - kShapeNumbers)
                           .cwiseSqrt();
    body.mass_centre_T = model.path.tail<3>();
    body.mass_centre_sigma = model.covariance.diagonal().tail<3>().cwiseSqrt();
  }
  return body;
}

/// The one of two estimates of the same body with the smaller errors of inertia.
const KnownBody& surer(const KnownBody& a, const KnownBody& b) {
  const bool b_is_surer =
      b.known && (!a.known || b.shape_sigma.maxCoeff() < a.shape_sigma.maxCoeff());
  return b_is_surer ? b : a;
}

Head head_of(const Component::State& s) {
  const Map& map = s.mapping.map;
  Head head{.facts = {.keyframes = static_cast<std::uint32_t>(map.keyframe_count),
                      .landmarks = static_cast<std::uint32_t>(map.landmark_count),
                      .radius_mu = map.radius_mu,
                      .scale_known = s.scale.known,
                      .metres_per_mu = s.scale.metres_per_mu,
                      .scale_sigma = s.scale.relative_sigma,
                      .body = surer(s.motion.known_body, body_of(s.motion.model))},
            .drift = s.mapping.drift};
  return head;
}

/// Keyframe slots by age, the oldest first.
FixedVector<KeyframeId, limits::kKeyframes> oldest_first(const Map& map) {
  auto order = keyframes_by_age(map);
  std::reverse(order.begin(), order.end());
  return order;
}

/// Numbers of keyframes, the oldest first.
using Ages = FixedVector<std::uint32_t, limits::kKeyframes>;

/// Rank of the last keyframe that is not younger than a number. Numbers grow during a run; ranks do
/// not grow from pass to pass.
std::uint32_t rank_of(std::uint32_t number, const Ages& numbers) {
  const auto younger = std::upper_bound(numbers.begin(), numbers.end(), number);
  return static_cast<std::uint32_t>(std::max<std::ptrdiff_t>(0, younger - numbers.begin() - 1));
}

using Places = std::array<std::uint32_t, limits::kLandmarks>;

void write_keyframe(const Keyframe& keyframe,
                    std::int64_t newest_ns,
                    const Places& place,
                    double focal_px,
                    Writer* out) {
  std::int64_t age_ns = newest_ns - keyframe.timestamp_ns;
  std::uint32_t features = 0;
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    features += keyframe.landmark_of[i].valid() ? 1 : 0;
  }
  put_keyframe(out, keyframe, age_ns, features);
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    const LandmarkId id = keyframe.landmark_of[i];
    if (id.valid()) {
      const StoredFeature f = stored(keyframe.features[i], place[id.index()], focal_px);
      put_feature(out, f);
    }
  }
}

/// Is it a covariance: positive semi-definite?
bool is_error(const PoseCovariance& covariance) {
  return Eigen::LDLT<PoseCovariance>(covariance).isPositive();
}

bool is_valid(const Head& head) {
  const MapDrift& d = head.drift;
  return validity::is_at_least(head.facts.metres_per_mu, 1e-12) &&
         validity::is_at_least(head.facts.scale_sigma, 0.0) && polhode::is_valid(head.facts.body) &&
         polhode::is_valid(d) && is_error(d.walk) && is_error(d.fixed) && is_error(d.reanchoring) &&
         d.reanchored_keyframe < head.facts.keyframes;
}

bool read_landmarks(std::uint32_t count, Reader* in, Map* map) {
  for (std::uint32_t n = 0; n < count && in->good(); ++n) {
    Landmark& landmark = map->landmarks[add_landmark(map).index()];
    put_landmark(in, landmark, landmark.created_keyframe, landmark.seen_keyframe);
  }
  return in->good();
}

bool read_keyframe(const CameraModel& camera, Reader* in, Map* map) {
  const KeyframeId id = add_keyframe(map);
  Keyframe& keyframe = map->keyframes[id.index()];
  std::int64_t age_ns = 0;
  std::uint32_t features = 0;
  put_keyframe(in, keyframe, age_ns, features);
  keyframe.timestamp_ns = -age_ns;
  keyframe.frame = UINT32_MAX;  // of no frame of this run
  if (!in->good() || age_ns < 0 || age_ns > validity::kTimeMax_ns / 2 ||
      features > keyframe.features.capacity()) {
    return false;
  }
  std::bitset<limits::kLandmarks> seen;
  for (std::uint32_t i = 0; i < features; ++i) {
    StoredFeature f;
    put_feature(in, f);
    if (!in->good() || f.landmark >= static_cast<std::uint32_t>(map->landmark_count) ||
        seen[f.landmark]) {
      return false;
    }
    seen.set(f.landmark);
    (void)keyframe.features.push_back(feature_of(f, camera));
    add_observation(id, i, LandmarkId::from_index(f.landmark), map);
  }
  return true;
}

/// @return the reason where it fails; the map then holds a part.
const char* read_all(Reader in, const CameraModel& camera, Head* head, Map* map) {
  std::uint32_t version = 0;
  put(&in, version);
  if (!in.good() || version != kTargetModelVersion) {
    return "of another version";
  }
  put_head(&in, *head);
  if (head->facts.keyframes > limits::kKeyframes || head->facts.landmarks > limits::kLandmarks) {
    return "larger than this program's tables";
  }
  bool good = in.good() && read_landmarks(head->facts.landmarks, &in, map);
  for (std::uint32_t k = 0; k < head->facts.keyframes && good; ++k) {
    good = read_keyframe(camera, &in, map);
  }
  good = good && in.at_end() && head->facts.keyframes > 0 && is_valid(*head);
  return good ? nullptr : "cut off, or with values that no run leaves";
}

}  // namespace

std::size_t target_model_octets_max() {
  return sizeof(std::uint32_t) + kHeadOctetsMax + limits::kLandmarks * kLandmarkOctetsMax +
         limits::kKeyframes * (kKeyframeOctetsMax + limits::kFeatures * sizeof(StoredFeature));
}

std::size_t save_target_model(const Component& component, std::span<std::uint8_t> out) {
  const Component::State& s = *ComponentAccess::state(component);
  const Map& map = s.mapping.map;
  const auto order = oldest_first(map);
  if (order.empty()) {
    return 0;
  }
  Writer writer(out);
  put(&writer, kTargetModelVersion);
  Ages ages;
  for (const KeyframeId id : order) {
    (void)ages.push_back(map.keyframes[id.index()].number);
  }
  Head head = head_of(s);
  head.drift.reanchored_keyframe = rank_of(head.drift.reanchored_keyframe, ages);
  put_head(&writer, head);
  Places place{};
  std::uint32_t places = 0;
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    if (map.landmarks[i].used) {
      place[i] = places++;
      const std::uint32_t created = rank_of(map.landmarks[i].created_keyframe, ages);
      const std::uint32_t seen = rank_of(map.landmarks[i].seen_keyframe, ages);
      put_landmark(&writer, map.landmarks[i], created, seen);
    }
  }
  const std::int64_t newest_ns = map.keyframes[order.back().index()].timestamp_ns;
  for (const KeyframeId id : order) {
    write_keyframe(
        map.keyframes[id.index()], newest_ns, place, s.configuration.camera.focal_px(), &writer);
  }
  return writer.used();
}

Result<TargetModelFacts> load_target_model(std::span<const std::uint8_t> octets,
                                           Component* component) {
  Component::State* s = ComponentAccess::state(*component);
  MapState& mapping = s->mapping;
  Map& map = mapping.map;
  Head head;
  const CameraModel& camera = s->configuration.camera;
  const char* refusal = read_all(Reader(octets), camera, &head, &map);
  if (refusal == nullptr && is_valid(map, camera, 0)) {
    refresh_landmarks(&map, camera);
  }
  if (refusal == nullptr && !is_valid(map, camera, 0)) {
    refusal = "with values that no run leaves";
  }
  if (refusal != nullptr) {
    reset_map_and_motion(s);
    map.next_keyframe_number = 0;
    map.next_landmark_number = 0;
    return Error{ErrorCode::kBadParameter, refusal};
  }
  mapping.drift = head.drift;
  s->motion.known_body = head.facts.body;
  mapping.target_frame = 1;
  s->bus.reported.target_frame = 1;
  s->bus.reported.mode = Mode::kLost;  // so that the transition to TRACKING is reported
  mapping.last_adjustment_of_all = {.keyframes = head.facts.keyframes,
                                    .next_keyframe_number = map.next_keyframe_number};
  s->scale.known = head.facts.scale_known;
  s->scale.metres_per_mu = head.facts.metres_per_mu;
  s->scale.relative_sigma = head.facts.scale_sigma;
  s->scale.keyframes_at_reading = map.next_keyframe_number;
  change_mode(ModeEvent::kWarmStartWithMap, &s->mode);
  return head.facts;
}

void date_target_model(std::int64_t first_frame_ns, Map* map, MotionEstimate* motion) {
  // Longer than the time between keyframes of one pass, so that the passes are not taken for one
  // motion.
  constexpr std::int64_t kBefore_ns = 3'600'000'000'000;
  for (Keyframe& keyframe : map->keyframes) {
    keyframe.timestamp_ns += keyframe.used ? first_frame_ns - kBefore_ns : 0;
  }
  motion->moves_so_since_ns = first_frame_ns;
}

}  // namespace polhode
