# shellcheck shell=bash disable=SC2034
# For launch/sim and test/run, which source this: the system's python and ROS, and what to install.

# The system's programs come first: ROS's tools break under a python of pyenv or conda.
export PATH="/usr/bin:/bin:/usr/sbin:/sbin:$PATH"
unset PYTHONPATH PYTHONHOME

# Sources the setup of a ROS installation, devel space or install space.
enter() {
  set +u
  # shellcheck source=/dev/null
  source "$1/setup.bash"
  set -u
}

# ROS 1 in /opt/ros, which alone has .catkin there: that of ROS_DISTRO, or ROS One, or Noetic. Else that of Debian.
for distro in ${ROS_DISTRO:-} one noetic debian; do
  [ ! -e "/opt/ros/$distro/.catkin" ] || break
done

to_build=(build-essential cmake libboost-program-options-dev libeigen3-dev libtinyxml2-dev libyaml-cpp-dev nlohmann-json3-dev
  libpython3-dev pybind11-dev)
if [ "$distro" != debian ]; then
  enter "/opt/ros/$distro"
  to_run=("${to_build[@]}" "ros-$distro-"{ros-base,diagnostic-updater,interactive-markers,rviz,tf,tf2-ros} python3-{jinja2,matplotlib,numpy,pil,scipy,sympy,yaml})
  to_test=("ros-$distro-"{kdl-parser,rostest})
else
  # Debian splits a message package in three: definitions (ros-…), C++ (lib…-dev), python.
  to_run=("${to_build[@]}" catkin ros-message-generation ros-message-runtime libroscpp-dev libtf2-ros-dev
    ros-{std,geometry,sensor,trajectory,visualization}-msgs lib{std,geometry,sensor,tf2,trajectory,visualization}-msgs-dev
    libdiagnostic-updater-dev libinteractive-markers-dev
    librosbag-storage-dev libros-rosgraph-msgs-dev libstd-srvs-dev
    python3-{diagnostic,geometry,rosgraph,sensor,std,tf2,trajectory,visualization}-msgs python3-std-srvs
    python3-{jinja2,matplotlib,numpy,pil,roslaunch,rosbag,rosnode,rospy,rosservice,rostopic,scipy,sympy,yaml} rosbash rosout rviz tf-tools)
  to_test=(chromium chromium-driver libkdl-parser-dev librostest-dev python3-{distributed,rostest,tornado})
  grep -q bullseye /etc/os-release || to_test+=(libmujoco-dev)  # not in Debian 11
fi
to_test+=(catkin-lint clang-format doxygen ffmpeg libgtest-dev liburdfdom-tools python3-venv qemu-user shellcheck valgrind)

# Installs those of the packages named that are missing; asks nothing, and needs no network if none is.
install_missing() {
  local missing root=() log
  mapfile -t missing < <(comm -23 <(printf '%s\n' "$@" | sort -u) \
    <(dpkg-query -W -f '${db:Status-Status} ${Package}\n' | sed -n 's/^installed //p' | sort -u))
  [ ${#missing[@]} -gt 0 ] || return 0
  echo "Installing with apt: ${missing[*]}"
  [ "$(id -u)" = 0 ] || root=(sudo)
  log=$(mktemp)
  {
    "${root[@]}" apt-get -q update
    "${root[@]}" env DEBIAN_FRONTEND=noninteractive \
      apt-get -qy --no-install-recommends install "${missing[@]}"
  } >"$log" 2>&1 || { cat "$log" >&2; return 1; }
  rm "$log"
}

# Builds a target in a folder, with options for cmake: build_in FOLDER TARGET OPTION…. Shows the percentage, and what the compiler says
# only if it fails. Says nothing where all is built.
build_in() {
  local log=$1/build.log next=0 begin="Building ($1/build.log)"
  [ -e "$1/CMakeCache.txt" ] || { printf '%s' "$begin"; begin=; }  # the first time, cmake alone takes seconds
  mkdir -p "$1"
  { cmake -S . -B "$1" "${@:3}" && cmake --build "$1" --target "$2" --parallel "$(nproc)"; } 2>&1 | tee "$log" | {
    while read -r line; do
      [[ $line =~ ^\[\ *([0-9]+)%\]\ ([A-Za-z]+) && ( -z $begin || ${BASH_REMATCH[2]} != Built ) ]] || continue
      printf '%s' "$begin"
      begin=
      ((BASH_REMATCH[1] >= next)) || continue
      printf ' %d%%' "${BASH_REMATCH[1]}"
      next=$((BASH_REMATCH[1] + 10))
    done
    [ -n "$begin" ] || echo
  } || { cat "$log" >&2; return 1; }
}

# Builds all into build/, which takes some minutes the first time.
build() { build_in build all -DPYTHON_EXECUTABLE=/usr/bin/python3 "$@"; }
