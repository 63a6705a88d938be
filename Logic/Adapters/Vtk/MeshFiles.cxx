#include "Adapters/Vtk/MeshFiles.h"

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkExecutive.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataWriter.h>
#include <vtkSignedCharArray.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridWriter.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <new>

#include "Adapters/Vtk/Conversions.h"
#include "Adapters/Vtk/SurfaceFormats.h"
#include "CaseIO/AtomicFile.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

/// Catches VTK's error events, which would otherwise only be printed.
class ErrorObserver {
 public:
  ErrorObserver() {
    command_->SetClientData(this);
    command_->SetCallback([](vtkObject*, unsigned long, void* self, void* text) {
      auto& message = static_cast<ErrorObserver*>(self)->message_;
      if (message.empty()) message = text ? static_cast<const char*>(text) : "unknown error";
    });
  }
  void Watch(vtkObject* object) {
    if (!object) return;
    object->AddObserver(vtkCommand::ErrorEvent, command_);
    object->AddObserver(vtkCommand::WarningEvent, command_);
  }
  vtkCommand* Command() { return command_; }
  /// @throws InputError with VTK's words, without its source lines
  void Check(const std::string& path) const {
    if (message_.empty()) return;
    std::string text = message_;
    const auto after = text.find("): ");
    if (after != std::string::npos) text = text.substr(after + 3);
    while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
    std::replace(text.begin(), text.end(), '\n', ' ');
    throw InputError(path, "", "cannot be read or written: " + text);
  }

 private:
  vtkNew<vtkCallbackCommand> command_;
  std::string message_;
};

std::string SpaceOf(vtkDataObject* data) {
  auto* tag = vtkStringArray::SafeDownCast(data->GetFieldData()->GetAbstractArray(kSpaceArray));
  return tag && tag->GetNumberOfValues() > 0 ? std::string(tag->GetValue(0)) : std::string();
}

void TagSpace(Space space, vtkDataObject* data) {
  vtkNew<vtkStringArray> tag;
  tag->SetName(kSpaceArray);
  tag->InsertNextValue(ToString(space));
  data->GetFieldData()->AddArray(tag);
}

void RequireXml(const std::string& path, const char* type) {
  std::ifstream in(path, std::ios::binary);
  std::string head(2000, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  if (head.find("<VTKFile") == std::string::npos)
    throw InputError(path, "header", "is no VTK XML file");
  if (head.find(type) == std::string::npos)
    throw InputError(path, "header", std::string("is no ") + type + " file");
}

/// Runs a VTK reader. Broken XML and legacy files end in InputError, also where they announce
/// absurd sizes.
template <typename Reader, typename Data>
vtkSmartPointer<Data> RunReader(const std::string& path) {
  vtkNew<Reader> reader;
  ErrorObserver errors;
  errors.Watch(reader);
  errors.Watch(reader->GetExecutive());
  if constexpr (std::is_base_of_v<vtkXMLReader, Reader>) {
    // The XML parser is made while reading.
    reader->SetParserErrorObserver(errors.Command());
  }
  reader->SetFileName(path.c_str());
  try {
    reader->Update();
  } catch (const std::bad_alloc&) {
    throw InputError(path, "", "announces more data than memory holds");
  } catch (const std::length_error&) {
    throw InputError(path, "", "announces more data than memory holds");
  }
  errors.Check(path);
  vtkSmartPointer<Data> data = reader->GetOutput();
  if (!data || data->GetNumberOfPoints() == 0)
    throw InputError(path, "points", "there are none: the file is empty or broken");
  return data;
}

SurfaceFile FromPolyData(vtkPolyData* data, const std::string& path, const std::string& tag) {
  SurfaceFile file;
  file.space = ParseSpace(tag, path, kSpaceArray);
  file.surface = SurfaceFromVtk(data, path);
  Points rest;
  if (RestPositionsFromVtk(data, &rest)) file.rest_position = std::move(rest);
  return file;
}

template <typename Writer>
void RunWriter(vtkDataObject* data, const std::string& path, Space space) {
  const std::string temporary = TemporaryNameBeside(path);
  vtkNew<Writer> writer;
  ErrorObserver errors;
  errors.Watch(writer);
  writer->SetInputData(data);
  writer->SetFileName(temporary.c_str());
  if constexpr (std::is_base_of_v<vtkXMLWriter, Writer>) {
    writer->SetDataModeToAppended();
    writer->EncodeAppendedDataOff();
  } else {
    writer->SetFileTypeToBinary();
    // Readable by programs that know version 4.2 only.
    writer->SetFileVersion(42);
    writer->SetHeader((std::string("Kerf, mm, SPACE=") + ToString(space)).c_str());
  }
  const int written = writer->Write();
  errors.Check(path);
  if (!written || writer->GetErrorCode() != 0) throw InputError(path, "", "cannot be written");
  CommitTemporary(temporary, path);
}

vtkSmartPointer<vtkDataArray> ArrayToVtk(const SurfaceArray& array) {
  const auto fill = [&](auto made, const auto& values) -> vtkSmartPointer<vtkDataArray> {
    made->SetName(array.name.c_str());
    made->SetNumberOfValues(static_cast<vtkIdType>(values.size()));
    std::copy(values.begin(), values.end(), made->GetPointer(0));
    return made;
  };
  struct Visitor {
    decltype(fill)& make;
    auto operator()(const std::vector<std::int8_t>& v) const {
      return make(vtkSmartPointer<vtkSignedCharArray>::New(), v);
    }
    auto operator()(const std::vector<std::int32_t>& v) const {
      return make(vtkSmartPointer<vtkIntArray>::New(), v);
    }
    auto operator()(const std::vector<float>& v) const {
      return make(vtkSmartPointer<vtkFloatArray>::New(), v);
    }
  };
  return std::visit(Visitor{fill}, array.values);
}

Points InSpace(const Points& points, Space space) {
  return space == Space::LPS ? points : FlipSpace(points);
}

void RequireExists(const std::string& path) {
  if (!std::ifstream(path)) throw InputError(path, "", "cannot be opened");
}

}  // namespace

std::string ReadWholeFile(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path, "", "cannot be opened");
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad()) throw InputError(path, "", "cannot be read");
  if (bytes.empty()) throw InputError(path, "", "is empty");
  return bytes;
}

std::string FindSpaceTag(const std::string& text) {
  const auto at = text.find("SPACE=");
  if (at == std::string::npos) return "";
  std::size_t end = at + 6;
  while (end < text.size() && std::isalpha(static_cast<unsigned char>(text[end]))) ++end;
  return text.substr(at + 6, end - at - 6);
}

std::string FileExtension(const std::string& path) {
  const auto dot = path.find_last_of('.'), slash = path.find_last_of('/');
  if (dot == std::string::npos || (slash != std::string::npos && slash > dot)) return "";
  std::string extension = path.substr(dot + 1);
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool IsSurfaceExtension(const std::string& extension) {
  return extension == "vtp" || extension == "stl" || extension == "ply" || extension == "obj";
}

SurfaceFile ReadSurfaceFile(const std::string& path) {
  RequireExists(path);
  const std::string extension = FileExtension(path);
  SurfaceFile file;
  if (extension == "vtp") {
    RequireXml(path, "PolyData");
    const auto data = RunReader<vtkXMLPolyDataReader, vtkPolyData>(path);
    file = FromPolyData(data, path, SpaceOf(data));
  } else if (extension == "stl" || extension == "ply" || extension == "obj") {
    RawSurface raw = extension == "stl"   ? ReadStl(path)
                     : extension == "ply" ? ReadPly(path)
                                          : ReadObj(path);
    file.space = ParseSpace(raw.space_tag, path, kSpaceArray);
    file.surface = std::move(raw.surface);
    file.surface.Validate(path);
  } else {
    throw InputError(path, "", "is no surface file (.vtp .stl .ply .obj)");
  }
  if (file.surface.Empty()) throw InputError(path, "triangles", "there are none");
  file.surface.points = InSpace(file.surface.points, file.space);
  if (file.rest_position) *file.rest_position = InSpace(*file.rest_position, file.space);
  return file;
}

SurfaceMesh ReadSurface(const std::string& path) { return ReadSurfaceFile(path).surface; }

std::vector<Index> ReadPointArray(const std::string& path, const std::string& name,
                                  Index expected) {
  RequireExists(path);
  RequireXml(path, "PolyData");
  const auto data = RunReader<vtkXMLPolyDataReader, vtkPolyData>(path);
  vtkDataArray* array = data->GetPointData()->GetArray(name.c_str());
  if (!array) throw InputError(path, "point array " + name, "is missing");
  if (array->GetNumberOfTuples() != expected || array->GetNumberOfComponents() != 1)
    throw InputError(path, "point array " + name, "does not fit the points");
  std::vector<Index> values(expected);
  for (Index i = 0; i < expected; ++i) values[i] = static_cast<Index>(array->GetTuple1(i));
  return values;
}

void WriteSurface(const SurfaceMesh& surface, const std::string& path, Space space,
                  const Points* rest_position) {
  const std::string extension = FileExtension(path);
  SurfaceMesh turned = surface;
  turned.points = InSpace(surface.points, space);
  if (extension == "vtp" || extension == "vtk") {
    std::optional<Points> rest;
    if (rest_position) rest = InSpace(*rest_position, space);
    const auto data = ToVtk(turned, rest ? &*rest : nullptr);
    TagSpace(space, data);
    if (extension == "vtp")
      RunWriter<vtkXMLPolyDataWriter>(data, path, space);
    else
      RunWriter<vtkPolyDataWriter>(data, path, space);
    return;
  }
  if (extension != "stl" && extension != "ply" && extension != "obj" && extension != "glb")
    throw UsageError(path + ": surfaces are written as .vtp .stl .ply .obj .vtk .glb");
  AtomicFile file(path);
  if (extension == "stl") WriteStl(turned, ToString(space), file.Stream());
  if (extension == "ply") WritePly(turned, ToString(space), file.Stream());
  if (extension == "obj") WriteObj(turned, ToString(space), file.Stream());
  if (extension == "glb") WriteGlb(surface, file.Stream());
  file.Commit();
}

void WriteSurfaceWithArrays(const SurfaceMesh& surface, const std::string& path, Space space,
                            const std::vector<SurfaceArray>& arrays) {
  if (FileExtension(path) != "vtp")
    throw UsageError(path + ": surfaces with point arrays are written as .vtp");
  const auto data = ToVtk(SurfaceMesh{InSpace(surface.points, space), surface.triangles});
  TagSpace(space, data);
  for (const SurfaceArray& array : arrays) {
    const vtkSmartPointer<vtkDataArray> values = ArrayToVtk(array);
    if (values->GetNumberOfTuples() != data->GetNumberOfPoints())
      throw InputError(path, "array " + array.name, "has not one value per point");
    data->GetPointData()->AddArray(values);
  }
  RunWriter<vtkXMLPolyDataWriter>(data, path, space);
}

TetMesh ReadTetMesh(const std::string& path, Points* positions) {
  RequireExists(path);
  const std::string extension = FileExtension(path);
  vtkSmartPointer<vtkUnstructuredGrid> grid;
  std::string tag;
  if (extension == "vtu") {
    RequireXml(path, "UnstructuredGrid");
    grid = RunReader<vtkXMLUnstructuredGridReader, vtkUnstructuredGrid>(path);
    tag = SpaceOf(grid);
  } else {
    throw InputError(path, "", "is no tetrahedral mesh file (.vtu)");
  }
  const Space space = ParseSpace(tag, path, kSpaceArray);
  Points current;
  TetMesh mesh = TetMeshFromVtk(grid, path, &current);
  if (mesh.TetCount() == 0) throw InputError(path, "cells", "there are none");
  mesh.rest = InSpace(mesh.rest, space);
  if (positions) *positions = InSpace(current, space);
  return mesh;
}

void WriteTetMesh(const TetMesh& mesh, const Points& positions, const std::string& path,
                  Space space) {
  const std::string extension = FileExtension(path);
  if (extension != "vtu" && extension != "vtk")
    throw UsageError(path + ": tetrahedral meshes are written as .vtu .vtk");
  TetMesh turned = mesh;
  turned.rest = InSpace(mesh.rest, space);
  const auto grid = ToVtk(turned, InSpace(positions, space));
  TagSpace(space, grid);
  if (extension == "vtu")
    RunWriter<vtkXMLUnstructuredGridWriter>(grid, path, space);
  else
    RunWriter<vtkUnstructuredGridWriter>(grid, path, space);
}

}  // namespace kerf
