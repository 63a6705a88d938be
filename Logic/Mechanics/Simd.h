#pragma once

#include <immintrin.h>

#include <cstdint>

namespace kerf::simd {

/// Eight single-precision lanes: one per tetrahedron of a block. Arithmetic by the compiler's
/// vector extension.
typedef float F8 __attribute__((vector_size(32)));
/// A vertex quantity x, y, z, 0.
struct alignas(16) F4 {
  float x = 0, y = 0, z = 0, w = 0;
};

inline F8 Splat(float value) { return F8{} + value; }
inline F8 Max(F8 a, F8 b) { return (F8)_mm256_max_ps((__m256)a, (__m256)b); }
inline F8 Min(F8 a, F8 b) { return (F8)_mm256_min_ps((__m256)a, (__m256)b); }
inline F8 Sqrt(F8 a) { return (F8)_mm256_sqrt_ps((__m256)a); }
inline F8 Abs(F8 a) { return (F8)_mm256_andnot_ps(_mm256_set1_ps(-0.0f), (__m256)a); }
/// Magnitude of a with the sign of b.
inline F8 WithSign(F8 a, F8 b) {
  const __m256 sign = _mm256_set1_ps(-0.0f);
  return (F8)_mm256_or_ps(_mm256_andnot_ps(sign, (__m256)a), _mm256_and_ps(sign, (__m256)b));
}
/// a where b ≥ 0, else −a.
inline F8 FlipSign(F8 a, F8 b) {
  const __m256 sign = _mm256_set1_ps(-0.0f);
  return (F8)_mm256_xor_ps((__m256)a, _mm256_and_ps(sign, (__m256)b));
}
/// Bit i set where lane i of a > b (false for NaN).
inline int Greater(F8 a, F8 b) {
  return _mm256_movemask_ps(_mm256_cmp_ps((__m256)a, (__m256)b, _CMP_GT_OQ));
}
inline float Sum(F8 a) {
  const __m128 half =
      _mm_add_ps(_mm256_castps256_ps128((__m256)a), _mm256_extractf128_ps((__m256)a, 1));
  const __m128 quarter = _mm_add_ps(half, _mm_movehl_ps(half, half));
  return _mm_cvtss_f32(_mm_add_ss(quarter, _mm_shuffle_ps(quarter, quarter, 1)));
}

/// Lane k is the sum of the lanes of a[k].
inline F8 Sums(const F8 a[8]) {
  const auto add = [](__m256 p, __m256 q) { return _mm256_hadd_ps(p, q); };
  const __m256 low = add(add((__m256)a[0], (__m256)a[1]), add((__m256)a[2], (__m256)a[3]));
  const __m256 high = add(add((__m256)a[4], (__m256)a[5]), add((__m256)a[6], (__m256)a[7]));
  return (F8)_mm256_permute2f128_ps(low, high, 0x20) + (F8)_mm256_permute2f128_ps(low, high, 0x31);
}
/// Lane k of row i becomes lane i of row k.
inline void Transpose(F8 a[8]) {
  __m256 pair[8], four[8];
  for (int i = 0; i < 8; i += 2) {
    pair[i] = _mm256_unpacklo_ps((__m256)a[i], (__m256)a[i + 1]);
    pair[i + 1] = _mm256_unpackhi_ps((__m256)a[i], (__m256)a[i + 1]);
  }
  for (int i = 0; i < 8; i += 4)
    for (int k = 0; k < 2; ++k) {
      four[i + 2 * k] = _mm256_shuffle_ps(pair[i + k], pair[i + k + 2], 0x44);
      four[i + 2 * k + 1] = _mm256_shuffle_ps(pair[i + k], pair[i + k + 2], 0xEE);
    }
  for (int k = 0; k < 4; ++k) {
    a[k] = (F8)_mm256_permute2f128_ps(four[k], four[k + 4], 0x20);
    a[k + 4] = (F8)_mm256_permute2f128_ps(four[k], four[k + 4], 0x31);
  }
}

inline __m128 Load(const F4& v) { return _mm_load_ps(&v.x); }
inline void Store(F4* v, __m128 value) { _mm_store_ps(&v->x, value); }
inline float Dot3(__m128 a, __m128 b) { return _mm_cvtss_f32(_mm_dp_ps(a, b, 0x71)); }

/// Vertex quantities of eight corners, transposed to lanes.
inline void Gather(const F4* values, const std::uint16_t* index, F8 out[3]) {
  auto pair = [&](int lane) {
    return _mm256_insertf128_ps(_mm256_castps128_ps256(Load(values[index[lane]])),
                                Load(values[index[lane + 4]]), 1);
  };
  const __m256 r0 = pair(0), r1 = pair(1), r2 = pair(2), r3 = pair(3);
  const __m256 xy01 = _mm256_unpacklo_ps(r0, r1), z01 = _mm256_unpackhi_ps(r0, r1);
  const __m256 xy23 = _mm256_unpacklo_ps(r2, r3), z23 = _mm256_unpackhi_ps(r2, r3);
  out[0] = (F8)_mm256_shuffle_ps(xy01, xy23, 0x44);
  out[1] = (F8)_mm256_shuffle_ps(xy01, xy23, 0xEE);
  out[2] = (F8)_mm256_shuffle_ps(z01, z23, 0x44);
}

/// Adds lanes to the vertex quantities of eight corners, one after the other (corners may repeat).
inline void ScatterAdd(const F8 in[3], const std::uint16_t* index, F4* values) {
  const __m256 zero = _mm256_setzero_ps();
  const __m256 xy_lo = _mm256_unpacklo_ps((__m256)in[0], (__m256)in[1]);
  const __m256 xy_hi = _mm256_unpackhi_ps((__m256)in[0], (__m256)in[1]);
  const __m256 z_lo = _mm256_unpacklo_ps((__m256)in[2], zero);
  const __m256 z_hi = _mm256_unpackhi_ps((__m256)in[2], zero);
  const __m256 rows[4] = {
      _mm256_shuffle_ps(xy_lo, z_lo, 0x44), _mm256_shuffle_ps(xy_lo, z_lo, 0xEE),
      _mm256_shuffle_ps(xy_hi, z_hi, 0x44), _mm256_shuffle_ps(xy_hi, z_hi, 0xEE)};
  for (int lane = 0; lane < 4; ++lane) {
    F4* low = values + index[lane];
    Store(low, _mm_add_ps(Load(*low), _mm256_castps256_ps128(rows[lane])));
    F4* high = values + index[lane + 4];
    Store(high, _mm_add_ps(Load(*high), _mm256_extractf128_ps(rows[lane], 1)));
  }
}

}  // namespace kerf::simd
