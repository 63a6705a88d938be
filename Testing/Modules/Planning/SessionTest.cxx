#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "Core/Errors.h"
#include "Session/CaseBrowser.h"
#include "Session/PlanningAutosave.h"
#include "Session/PlanningSession.h"
#include "Session/UndoStack.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

Volume Ct() {
  Volume ct;
  ct.grid.size = {20, 16, 12};
  ct.grid.spacing_mm = {1, 1, 2};
  ct.source = "ct.nrrd";
  ct.voxels = std::make_shared<std::vector<std::int16_t>>(ct.grid.VoxelCount(), 100);
  return ct;
}

void PaintOnce(PlanningSession& session, double x) {
  session.BeginStroke();
  LabelEditor::Brush brush;
  brush.radius_mm = 3;
  session.Dab(brush, Vec3(x, 8, 6));
  session.EndStroke("paint");
}

std::shared_ptr<const PlanningModel> BoxModel() {
  auto model = std::make_shared<PlanningModel>();
  model->mesh = testing::BoxMesh({30, 20, 10}, 6, 4, 2);
  model->organ_surface = BoundarySurface(model->mesh, model->mesh.rest);
  model->quality = MeasureQuality(model->mesh, model->mesh.rest);
  return model;
}

class WorkFile : public ::testing::Test {
 protected:
  std::string file_ =
      (std::filesystem::temp_directory_path() / ("kerf-work-" + std::to_string(::getpid())))
          .string();
  ~WorkFile() override { std::filesystem::remove(file_); }
};

}  // namespace

TEST(UndoStack, NamesAndOrder) {
  UndoStack stack;
  int value = 0, told = 0;
  stack.SetListener([&told] { ++told; });
  for (const int v : {1, 2}) {
    const int before = value;
    value = v;
    stack.Push({"set " + std::to_string(v), [&value, before] { value = before; },
                [&value, v] { value = v; }});
  }
  EXPECT_EQ(stack.UndoName(), "set 2");
  EXPECT_TRUE(stack.Undo());
  EXPECT_EQ(value, 1);
  EXPECT_EQ(stack.RedoName(), "set 2");
  EXPECT_TRUE(stack.Undo());
  EXPECT_FALSE(stack.Undo());
  EXPECT_EQ(value, 0);
  EXPECT_TRUE(stack.Redo());
  EXPECT_EQ(value, 1);
  stack.Push({"other", [] {}, [] {}});
  EXPECT_FALSE(stack.CanRedo());
  EXPECT_EQ(told, 6);
}

TEST(UndoStack, OldStepsGoWhenTheyAreTooMuch) {
  UndoStack stack(100);
  for (int i = 0; i < 5; ++i) stack.Push({std::to_string(i), [] {}, [] {}, 40});
  EXPECT_EQ(stack.Count(), 2u);
  EXPECT_EQ(stack.Bytes(), 80u);
  stack.Push({"huge", [] {}, [] {}, 1000});
  EXPECT_EQ(stack.Count(), 1u);
  EXPECT_EQ(stack.UndoName(), "huge");
}

TEST(PlanningSession, EverythingIsUndoneInOrder) {
  UndoStack undo;
  PlanningSession session(undo);
  session.SetVolume(Ct(), "/ct.nrrd", "", {});
  PaintOnce(session, 8);
  session.AddSeed("organ", Vec3(1, 2, 3));
  session.SetMargin(7);
  session.AddLinePoint(Vec3(0, 0, 0));
  session.AddLandmark(Vec3(1, 1, 1));
  session.RenameLandmark(0, "hilum");
  EXPECT_EQ(undo.Count(), 6u);
  EXPECT_EQ(undo.UndoName(), "rename landmark");
  undo.Undo();
  EXPECT_EQ(session.Landmarks()[0].label, "landmark-1");
  while (undo.Undo()) {
  }
  EXPECT_TRUE(session.Labels().Empty());
  EXPECT_TRUE(session.Seeds().empty());
  EXPECT_TRUE(session.Landmarks().empty());
  EXPECT_EQ(session.Plan().line.rows(), 0);
  EXPECT_EQ(session.Plan().margin_mm, ResectionPlan().margin_mm);
  while (undo.Redo()) {
  }
  EXPECT_EQ(session.Landmarks()[0].label, "hilum");
  EXPECT_FALSE(session.Labels().Empty());
}

TEST(PlanningSession, MeshIsStaleAfterAnEditAndNotAfterItsUndo) {
  UndoStack undo;
  PlanningSession session(undo);
  session.SetVolume(Ct(), "/ct.nrrd", "", {});
  PaintOnce(session, 8);
  EXPECT_FALSE(session.CanSave());
  session.SetModel(BoxModel(), session.LabelsState());
  EXPECT_EQ(session.Status(PlanningStep::Mesh).state, StepState::Done);
  EXPECT_TRUE(session.CanSave());
  PaintOnce(session, 14);
  EXPECT_EQ(session.Status(PlanningStep::Mesh).state, StepState::Problem);
  EXPECT_FALSE(session.CanSave());
  undo.Undo();
  EXPECT_EQ(session.Status(PlanningStep::Mesh).state, StepState::Done);
  undo.Redo();
  EXPECT_TRUE(session.ModelIsStale());
}

TEST(PlanningSession, StepsSayWhatToDoNext) {
  UndoStack undo;
  PlanningSession session(undo);
  for (int s = 0; s < kPlanningSteps; ++s) {
    const StepStatus status = session.Status(static_cast<PlanningStep>(s));
    EXPECT_EQ(status.state, StepState::ToDo);
    EXPECT_FALSE(status.sentence.empty());
  }
  session.SetVolume(Ct(), "/ct.nrrd", "", {"slices are 5 mm apart"});
  EXPECT_EQ(session.Status(PlanningStep::Import).state, StepState::Problem);
  PaintOnce(session, 8);
  session.SetModel(BoxModel(), session.LabelsState());
  session.AddLandmark(Vec3(0, 0, 0));
  EXPECT_EQ(session.Status(PlanningStep::Camera).state, StepState::ToDo);
  session.SetCamera({}, "camera.yml");
  EXPECT_EQ(session.Status(PlanningStep::Camera).state, StepState::Problem);
  for (int i = 0; i < 3; ++i) session.AddLandmark(Vec3(i, 1, 1));
  EXPECT_EQ(session.Status(PlanningStep::Camera).state, StepState::Done);
  EXPECT_TRUE(session.IsDirty());
  session.SetSaved("/case");
  EXPECT_FALSE(session.IsDirty());
  EXPECT_EQ(session.Status(PlanningStep::Save).state, StepState::Done);
  session.SetMargin(9);
  EXPECT_EQ(session.Status(PlanningStep::Save).state, StepState::ToDo);
}

TEST(PlanningSession, MeasuresGoWithThePlanTheyBelongTo) {
  UndoStack undo;
  PlanningSession session(undo);
  session.SetVolume(Ct(), "/ct.nrrd", "", {});
  PaintOnce(session, 8);
  session.SetModel(BoxModel(), session.LabelsState());
  session.AddLinePoint(Vec3(0, -10, 5));
  session.AddLinePoint(Vec3(0, 10, 5));
  Progress silent;
  session.SetMeasures(MeasureResection(*session.Model(), session.Plan(), silent), 0);
  EXPECT_TRUE(session.Measures()->divides);
  EXPECT_EQ(session.Status(PlanningStep::Plan).state, StepState::Done);
  session.SetDepth(3);
  EXPECT_FALSE(session.Measures());
}

TEST(PlanningSession, DirectionFollowsTheLineUntilItIsGiven) {
  UndoStack undo;
  PlanningSession session(undo);
  session.SetVolume(Ct(), "/ct.nrrd", "", {});
  PaintOnce(session, 8);
  session.SetModel(BoxModel(), session.LabelsState());
  session.AddLinePoint(Vec3(0, -5, 5));
  EXPECT_LT((session.Plan().direction - Vec3(0, 0, -1)).norm(), 1e-9);
  session.SetDirection(Vec3(0, 2, 0));
  session.AddLinePoint(Vec3(0, 5, 5));
  EXPECT_EQ(session.Plan().direction, Vec3(0, 1, 0));
  session.FollowSurface();
  EXPECT_LT((session.Plan().direction - Vec3(0, 0, -1)).norm(), 1e-9);
  undo.Undo();
  EXPECT_EQ(session.Plan().direction, Vec3(0, 1, 0));
}

TEST_F(WorkFile, AutosaveGivesEverythingBack) {
  UndoStack undo;
  PlanningSession session(undo);
  session.SetVolume(Ct(), "/data/ct", "1.2.3", {});
  PaintOnce(session, 8);
  session.AddSeed("tumour", Vec3(1, 2, 3));
  session.AddLandmark(Vec3(4, 5, 6), "pole");
  session.AddLinePoint(Vec3(0, 1, 2));
  session.SetMargin(8.5);
  CameraModel camera;
  camera.width = 1920;
  camera.fx = 1100.5;
  camera.distortion[1] = 0.25;
  session.SetCamera(camera, "/data/camera.yml");
  SaveWork(TakeWork(session), file_);
  const PlanningWork work = LoadWork(file_);
  EXPECT_EQ(work.ct_path, "/data/ct");
  EXPECT_EQ(CtOfWork(file_), "/data/ct");
  EXPECT_EQ(work.series, "1.2.3");
  EXPECT_EQ(*work.labels.voxels, *session.Labels().Labels().voxels);
  EXPECT_TRUE(work.labels.grid.SameAs(session.Ct()->grid));
  EXPECT_EQ(work.rest.seeds[0].label, "tumour");
  EXPECT_EQ(work.rest.landmarks[0].position_mm, Vec3(4, 5, 6));
  EXPECT_EQ(work.rest.plan.margin_mm, 8.5);
  EXPECT_EQ(work.rest.plan.line.rows(), 1);
  EXPECT_EQ(work.rest.camera->fx, 1100.5);
  EXPECT_EQ(work.rest.camera->distortion[1], 0.25);
}

TEST_F(WorkFile, BrokenAutosavesAreRefusedNotBelieved) {
  UndoStack undo;
  PlanningSession session(undo);
  session.SetVolume(Ct(), "/data/ct", "", {});
  PaintOnce(session, 8);
  SaveWork(TakeWork(session), file_);
  std::ifstream in(file_, std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), {});
  for (std::size_t length = 0; length < whole.size(); length += 7) {
    std::ofstream(file_, std::ios::binary | std::ios::trunc) << whole.substr(0, length);
    EXPECT_THROW(LoadWork(file_), InputError) << length;
  }
  std::ofstream(file_, std::ios::binary | std::ios::trunc) << "something else entirely";
  EXPECT_THROW(LoadWork(file_), InputError);
  EXPECT_EQ(CtOfWork(file_), "");
  EXPECT_THROW(LoadWork(file_ + "-missing"), InputError);
  EXPECT_EQ(CtOfWork(file_ + "-missing"), "");
}

TEST(CaseBrowser, RecentCasesAreNewestFirstAndUnique) {
  RecentCases recent({"/a", "/b", "/c"}, 3);
  recent.Add("/b");
  recent.Add("/d");
  EXPECT_EQ(recent.Folders(), (std::vector<std::string>{"/d", "/b", "/a"}));
  recent.Remove("/b");
  EXPECT_EQ(recent.Folders().size(), 2u);
}

TEST(CaseBrowser, AFolderThatIsNoCaseHasAProblemInWords) {
  const CaseSummary summary = SummarizeCase("/nowhere/at/all");
  EXPECT_FALSE(summary.problem.empty());
  EXPECT_EQ(summary.name, "all");
}

}  // namespace kerf
