#pragma once

#include <itkMultiThreaderBase.h>

namespace kerf::itk_bridge {

/// f(0) … f(count − 1) on ITK's threads, in any order: f writes where no other call reads.
template <class F>
void ParallelFor(int count, F&& f) {
  itk::MultiThreaderBase::New()->ParallelizeArray(
      0, static_cast<itk::SizeValueType>(count),
      [&f](itk::SizeValueType i) { f(static_cast<int>(i)); }, nullptr);
}

}  // namespace kerf::itk_bridge
