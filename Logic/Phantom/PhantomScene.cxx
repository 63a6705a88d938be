#include "Phantom/PhantomScene.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "Phantom/Noise.h"
#include "Phantom/PhantomMaterials.h"

namespace kerf {
namespace {

double Power(double x, int squarings) {
  for (int i = 0; i < squarings; ++i) x *= x;
  return x;
}

/// Lambert and two wet lobes under a headlight; `toward_eye` and `normal` are unit vectors.
Vec3 Shade(const SurfaceLook& look, const Vec3& normal, const Vec3& toward_eye, double fall_off) {
  const double facing = std::max(0.0, normal.dot(toward_eye));
  const Vec3 diffuse = look.albedo * (0.04 + 0.96 * facing);
  const double wet = look.gloss * (1.0 * Power(facing, 8) + 0.07 * Power(facing, 5));
  return fall_off * (diffuse + wet * Vec3(1.0, 0.97, 0.93));
}

Points VertexNormals(const Points& points, const Triangles& triangles) {
  Points normals = Points::Zero(points.rows(), 3);
  for (Index t = 0; t < triangles.rows(); ++t) {
    const Vec3 a = points.row(triangles(t, 0)), b = points.row(triangles(t, 1)),
               c = points.row(triangles(t, 2));
    const Vec3 n = (b - a).cross(c - a);
    for (int k = 0; k < 3; ++k) normals.row(triangles(t, k)) += n.transpose();
  }
  for (Index p = 0; p < points.rows(); ++p) normals.row(p).normalize();
  return normals;
}

Vec3 Interpolated(const Points& values, const Triangles& triangles, Index t,
                  const VisibilityBuffer& seen, std::size_t at) {
  const double b = seen.weight1[at], c = seen.weight2[at];
  return (1.0 - b - c) * values.row(triangles(t, 0)).transpose() +
         b * values.row(triangles(t, 1)).transpose() + c * values.row(triangles(t, 2)).transpose();
}

/// Separable box blur, repeated twice: close to a Gaussian.
void Blur(std::vector<float>* field, int width, int height, int radius) {
  std::vector<float> other(field->size());
  for (int pass = 0; pass < 4; ++pass) {
    const bool rows = pass % 2 == 0;
    const int lines = rows ? height : width, length = rows ? width : height;
    const std::size_t step = rows ? 1 : width, jump = rows ? width : 1;
    for (int line = 0; line < lines; ++line) {
      const float* in = field->data() + line * jump;
      float* out = other.data() + line * jump;
      double sum = 0.0;
      for (int i = -radius; i <= radius; ++i) sum += in[std::clamp(i, 0, length - 1) * step];
      for (int i = 0; i < length; ++i) {
        out[i * step] = static_cast<float>(sum / (2 * radius + 1));
        sum += in[std::min(i + radius + 1, length - 1) * step] - in[std::max(i - radius, 0) * step];
      }
    }
    field->swap(other);
  }
}

/// Lens blur (3×3 binomial), tone curve, sensor noise → 8 bit.
Image Develop(const std::vector<Eigen::Vector3f>& light, int width, int height,
              std::uint32_t seed) {
  constexpr int kTones = 8192;  // of 0..4 in linear light
  static const std::vector<float> tones = [] {
    std::vector<float> table(kTones);
    for (int i = 0; i < kTones; ++i)
      table[i] = static_cast<float>(
          255.0 * std::pow(1.0 - std::exp(-1.35 * 4.0 * i / kTones), 1.0 / 2.2) + 0.5);
    return table;
  }();
  static const std::vector<float> noise = [] {
    std::vector<float> table(1024);
    for (std::uint32_t i = 0; i < 1024; ++i)
      table[i] = static_cast<float>(1.8 * NormalFromHash(i * 7919U + 3U));
    return table;
  }();
  Image image;
  image.width = width;
  image.height = height;
  image.channels = 3;
  image.data.resize(std::size_t(width) * height * 3);
  tbb::parallel_for(0, height, [&](int v) {
    std::vector<Eigen::Vector3f> column(width);
    const Eigen::Vector3f* above = light.data() + std::size_t(std::max(v - 1, 0)) * width;
    const Eigen::Vector3f* here = light.data() + std::size_t(v) * width;
    const Eigen::Vector3f* below = light.data() + std::size_t(std::min(v + 1, height - 1)) * width;
    for (int u = 0; u < width; ++u)
      column[u] = 0.25F * above[u] + 0.5F * here[u] + 0.25F * below[u];
    std::uint8_t* out = image.data.data() + std::size_t(v) * width * 3;
    for (int u = 0; u < width; ++u) {
      const Eigen::Vector3f sum = 0.25F * column[std::max(u - 1, 0)] + 0.5F * column[u] +
                                  0.25F * column[std::min(u + 1, width - 1)];
      const std::uint32_t h =
          HashMix(static_cast<std::uint32_t>(v * width + u) * 0x9e3779b9U ^ seed);
      for (int c = 0; c < 3; ++c) {
        const int tone = std::min(static_cast<int>(sum[c] * (kTones / 4.0F)), kTones - 1);
        out[3 * u + 2 - c] = static_cast<std::uint8_t>(
            std::clamp(tones[std::max(tone, 0)] + noise[(h >> (10 * c)) & 1023U], 0.0F, 255.0F));
      }
    }
  });
  return image;
}

}  // namespace

PhantomScene::PhantomScene(const PhantomSetup& setup, const PhantomAnatomy& anatomy)
    : setup_(setup), anatomy_(anatomy), motion_(setup.motion) {
  const CameraModel& camera = setup.camera;
  const std::size_t count = std::size_t(camera.width) * camera.height;
  rays_.resize(count);
  background_.resize(count);
  const Eigen::Isometry3d organ_from_world = setup.world_from_organ.inverse();
  const Vec3 eye = organ_from_world * camera.Center();
  const double plane_z = setup.is_kidney ? -34.0 : -12.0;
  tbb::parallel_for(0, camera.height, [&](int v) {
    for (int u = 0; u < camera.width; ++u) {
      const std::size_t at = std::size_t(v) * camera.width + u;
      rays_[at] = camera.RayThrough(Vec2(u, v)).direction;
      const Vec3 ray = organ_from_world.linear() * rays_[at];
      const double reach = (plane_z - eye.z()) / ray.z();
      const Vec3 p = eye + reach * ray;
      const SurfaceLook look =
          setup.is_kidney ? FatBackground(p, setup.seed) : ClothBackground(p, setup.seed);
      const double near = std::abs(plane_z - eye.z());
      background_[at] = Shade(look, (Vec3::UnitZ() + look.bump).normalized(), -ray,
                              0.55 * Power(near / reach, 2) * (near / reach))
                            .cast<float>();
    }
  });
}

Vec3 PhantomScene::OrganColour(const PhantomSurfaceAtFrame& organ, const Points& world,
                               const Points& normals, const VisibilityBuffer& seen,
                               std::size_t at) const {
  const Index t = seen.triangle[at];
  const Triangles& triangles = organ.mesh.triangles;
  const double b = seen.weight1[at], c = seen.weight2[at];
  const std::array<double, 3> w{1.0 - b - c, b, c};
  Vec3 rest = Vec3::Zero();
  for (int k = 0; k < 3; ++k)
    rest += w[k] * anatomy_.organ.points.row(organ.pid[triangles(t, k)]).transpose();
  const bool section = anatomy_.organ_cut[organ.pid[triangles(t, 0)]] != 0;
  const SurfaceLook look = setup_.is_kidney ? (section ? KidneySection(rest, setup_.seed)
                                                       : KidneyCapsule(rest, setup_.seed))
                                            : SiliconeBand(rest, section, setup_.seed);
  Vec3 normal = Interpolated(normals, triangles, t, seen, at).normalized();
  normal = (normal + setup_.world_from_organ.linear() * look.bump).normalized();
  const Vec3 p = Interpolated(world, triangles, t, seen, at);
  const double distance = (p - setup_.camera.Center()).norm();
  const double reference = setup_.is_kidney ? 160.0 : 400.0;
  double fall_off = std::pow(reference / distance, 2.0);
  // Little light reaches the depth of the wound.
  if (section && setup_.is_kidney) fall_off *= 1.0 - 0.45 * SmoothRamp(12.0 - rest.z(), 0.0, 34.0);
  return Shade(look, normal, -rays_[at], fall_off);
}

Vec3 PhantomScene::ToolColour(const PhantomTool& tool, const Points& normals,
                              const VisibilityBuffer& seen, std::size_t at) const {
  const Index t = seen.triangle[at];
  const Triangles& triangles = tool.mesh.triangles;
  const Vec3 a = tool.mesh.points.row(triangles(t, 0));
  Vec3 normal = Interpolated(normals, triangles, t, seen, at).normalized();
  const Vec3 toward = -rays_[at];
  if (normal.dot(toward) < 0.0) normal = -normal;
  const double facing = normal.dot(toward);
  const double fall_off = std::pow(150.0 / ((a - setup_.camera.Center()).norm()), 2.0);
  if (tool.is_metal[triangles(t, 0)])
    return fall_off * Vec3(0.96, 1.0, 1.04) *
           (0.05 + 0.22 * facing + 0.75 * std::pow(facing, 14.0));
  const double coating = setup_.is_kidney ? 0.012 : 0.03;
  return fall_off * Vec3::Constant(coating + coating * facing + 0.10 * std::pow(facing, 40.0));
}

std::vector<float> PhantomScene::Shadow(const VisibilityBuffer& organ) const {
  // Contact shadow: the organ's blurred silhouette on what lies behind it, at a quarter of the
  // resolution.
  const int w = organ.width / 4, h = organ.height / 4;
  std::vector<float> field(std::size_t(w) * h);
  for (int v = 0; v < h; ++v)
    for (int u = 0; u < w; ++u)
      field[std::size_t(v) * w + u] = organ.Hit(organ.At(4 * u, 4 * v)) ? 1.0F : 0.0F;
  Blur(&field, w, h, 4);
  std::vector<float> out(std::size_t(organ.width) * organ.height);
  for (int v = 0; v < organ.height; ++v)
    for (int u = 0; u < organ.width; ++u) {
      const double x = std::min(u / 4.0, w - 1.001), y = std::min(v / 4.0, h - 1.001);
      const int i = static_cast<int>(x), j = static_cast<int>(y);
      const double fx = x - i, fy = y - j;
      const float* f = field.data() + std::size_t(j) * w + i;
      out[organ.At(u, v)] = static_cast<float>((1 - fy) * ((1 - fx) * f[0] + fx * f[1]) +
                                               fy * ((1 - fx) * f[w] + fx * f[w + 1]));
    }
  return out;
}

PhantomView PhantomScene::Render(int frame, bool draw) const {
  const CameraModel& camera = setup_.camera;
  PhantomSurfaceAtFrame organ = OrganAtFrame(anatomy_, motion_, frame);
  SurfaceMesh world{ToWorld(organ.mesh.points, setup_.world_from_organ), organ.mesh.triangles};
  PhantomView view;
  view.organ = VisibilityBuffer(camera.width, camera.height);
  Rasterize(world, camera, 0, &view.organ);
  const PhantomTool tool = ToolAtFrame(setup_, motion_, frame);
  VisibilityBuffer tool_seen(camera.width, camera.height);
  Rasterize(tool.mesh, camera, 0, &tool_seen);

  const std::size_t count = view.organ.triangle.size();
  view.tool.assign(count, 0);
  view.mask = Image{camera.width, camera.height, 1, std::vector<std::uint8_t>(count, 0)};
  for (std::size_t at = 0; at < count; ++at) {
    view.tool[at] = tool_seen.Hit(at) && tool_seen.depth_mm[at] < view.organ.depth_mm[at];
    if (view.organ.Hit(at)) view.mask.data[at] = view.tool[at] ? 128 : 255;
  }
  if (!draw) return view;

  const Points normals = VertexNormals(world.points, world.triangles);
  const Points tool_normals = VertexNormals(tool.mesh.points, tool.mesh.triangles);
  const std::vector<float> shadow = Shadow(view.organ);
  std::vector<Eigen::Vector3f> light(count);
  tbb::parallel_for(0, camera.height, [&](int v) {
    for (int u = 0; u < camera.width; ++u) {
      const std::size_t at = view.organ.At(u, v);
      if (view.tool[at])
        light[at] = ToolColour(tool, tool_normals, tool_seen, at).cast<float>();
      else if (view.organ.Hit(at))
        light[at] = OrganColour(organ, world.points, normals, view.organ, at).cast<float>();
      else
        light[at] = background_[at] * (1.0F - 0.8F * shadow[at]);
    }
  });
  view.image = Develop(light, camera.width, camera.height,
                       Hash(static_cast<std::uint32_t>(frame), 5, 6, setup_.seed));
  return view;
}

}  // namespace kerf
