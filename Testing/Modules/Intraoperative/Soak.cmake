# Plans the phantom and lets kerf-soak run over its video for a few seconds.
set(case "${PHANTOM}-case")
if(NOT EXISTS "${case}/case.json")
  execute_process(COMMAND "${KERF}" plan "${PHANTOM}/labels.nii.gz" --labels "${PHANTOM}/labels.nii.gz"
    --tetrahedra 4000 --output "${case}" RESULT_VARIABLE status)
  if(status)
    message(FATAL_ERROR "kerf plan: ${status}")
  endif()
endif()
execute_process(COMMAND "${SOAK}" "${case}" "${PHANTOM}/video.mp4" 8 1 120 "${PHANTOM}/camera.yml"
  RESULT_VARIABLE status OUTPUT_VARIABLE output)
message("${output}")
if(status)
  message(FATAL_ERROR "kerf-soak: ${status}")
endif()
if(NOT output MATCHES "growth after the first third")
  message(FATAL_ERROR "kerf-soak said nothing")
endif()
