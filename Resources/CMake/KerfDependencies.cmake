# Everything that Kerf uses, all from Debian 12. Order matters: Eigen by its own config before CGAL.
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED CONFIG)
find_package(TBB REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(CLI11 REQUIRED)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(OpenCV 4.6 REQUIRED COMPONENTS core imgproc imgcodecs videoio video calib3d features2d)
find_package(dlib REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(Qt5 5.15 REQUIRED COMPONENTS Core Gui Widgets Test)
find_package(VTK 9.1 REQUIRED COMPONENTS
  CommonCore CommonDataModel CommonTransforms CommonExecutionModel CommonMath FiltersCore FiltersGeneral FiltersGeometry
  FiltersModeling FiltersSources FiltersVerdict ImagingCore ImagingGeneral ImagingHybrid ImagingStencil IOXML IOGeometry
  IOPLY IOImage IOExport IOLegacy InteractionStyle RenderingCore RenderingAnnotation RenderingFreeType RenderingImage
  RenderingOpenGL2 GUISupportQt InteractionWidgets)
find_package(ITK 5.2 REQUIRED COMPONENTS
  ITKCommon ITKIOImageBase ITKIOGDCM ITKGDCM ITKIONIFTI ITKIONRRD ITKIOMeta ITKSmoothing ITKRegionGrowing ITKLevelSets
  ITKWatersheds ITKConnectedComponents ITKDistanceMap ITKMathematicalMorphology ITKLabelMap ITKLabelVoting ITKThresholding
  ITKImageGradient ITKImageIntensity ITKFastMarching ITKAnisotropicSmoothing ITKImageGrid ITKBinaryMathematicalMorphology)
find_package(CGAL 5.5 REQUIRED COMPONENTS ImageIO)
