#include "Adapters/Vtk/vtkKerfLabelMapToTetraGrid.h"

#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkUnstructuredGrid.h>

#include "Adapters/Vtk/Conversions.h"

vtkStandardNewMacro(vtkKerfLabelMapToTetraGrid);

namespace {

/// Logic's progress as VTK's, and VTK's abort as Logic's cancel.
class FilterProgress : public kerf::Progress {
 public:
  FilterProgress(vtkAlgorithm* filter, kerf::Progress* sink) : Filter(filter), Sink(sink) {}
  void Report(double fraction, const std::string& what) override {
    Filter->SetProgressText(what.c_str());
    Filter->UpdateProgress(fraction);
    if (Sink) Sink->Report(fraction, what);
  }
  void Warn(const std::string& message) override {
    if (Sink) Sink->Warn(message);
  }
  bool IsCancelled() const override {
    return Filter->GetAbortExecute() != 0 || (Sink && Sink->IsCancelled());
  }

 private:
  vtkAlgorithm* Filter;
  kerf::Progress* Sink;
};

}  // namespace

int vtkKerfLabelMapToTetraGrid::FillInputPortInformation(int, vtkInformation* info) {
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
  return 1;
}

int vtkKerfLabelMapToTetraGrid::RequestData(vtkInformation*, vtkInformationVector** input,
                                            vtkInformationVector* output) {
  this->Error = nullptr;
  this->Report = {};
  try {
    FilterProgress progress(this, this->Sink);
    kerf::MeshingOptions options;
    options.tetrahedra = this->Tetrahedra;
    options.min_dihedral_deg = this->MinimumDihedral;
    const kerf::LabelMap labels =
        kerf::LabelMapFromVtk(vtkImageData::GetData(input[0]), this->SourceName);
    const kerf::TetMesh mesh = kerf::MeshLabelMap(labels, options, progress, &this->Report);
    vtkUnstructuredGrid::GetData(output)->ShallowCopy(kerf::ToVtk(mesh));
  } catch (const kerf::Cancelled&) {
    this->Error = std::current_exception();
    vtkUnstructuredGrid::GetData(output)->Initialize();
  } catch (const std::exception& error) {
    this->Error = std::current_exception();
    vtkUnstructuredGrid::GetData(output)->Initialize();
    // A program that gave a sink asks by RethrowError() and has its own way to say it.
    if (this->Sink) return 1;
    vtkErrorMacro(<< error.what());
    return 0;
  }
  return 1;
}

void vtkKerfLabelMapToTetraGrid::RethrowError() const {
  if (this->Error) std::rethrow_exception(this->Error);
}

void vtkKerfLabelMapToTetraGrid::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Tetrahedra: " << this->Tetrahedra << "\n"
     << indent << "MinimumDihedral: " << this->MinimumDihedral << "\n"
     << indent << "SourceName: " << this->SourceName << "\n";
}
