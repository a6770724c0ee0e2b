//! What another user tries against a capture.

/// When another user tries something.
#[derive(Clone, Copy, PartialEq)]
pub enum When {
    Before,
    /// Before, and the rig is named by nothing but the user and the temporary directory.
    BeforeUnnamed,
    During,
}

/// What another user tries, as a shell script. Of the victim he knows everything but the contents of closed folders: the folder of
/// captures `OUT` and the temporary directory `TMP`, in which everybody may make files, the runtime directory `RIG`, the process
/// ids `PIDS`, the names of the coming seconds. `STRANGER` is an archive of another knob that says nothing of its run, `SECRET` a
/// file of the victim's that anybody may read. Where the script gets at something it says LEAK.
pub const TRIES: [(&str, &str, When, &str); 31] = [
    ("plant", "samples as parts, in the temporary directory", When::Before, "each cp $STRANGER $TMP/_T_.mcap.part-001"),
    ("plant", "samples as parts, beside the archive", When::Before, "each cp $STRANGER $OUT/_T_.mcap.part-001"),
    ("plant", "an archive, in the temporary directory", When::Before, "each cp $STRANGER $TMP/_T_.mcap"),
    (
        "plant",
        "an archive under the run's name",
        When::Before,
        "each cp $STRANGER $OUT/_T_.mcap; each cp $STRANGER $OUT/_T__02.mcap",
    ),
    ("plant", "pipes as parts", When::Before, "each mkfifo $TMP/_T_.mcap.part-000; each mkfifo $OUT/_T_.mcap.part-001"),
    ("plant", "folders as parts", When::Before, "each mkdir $TMP/_T_.mcap.part-000; each mkdir $OUT/_T_.mcap.part-000"),
    (
        "plant",
        "samples as parts of the running capture",
        When::During,
        "for n in 001 002; do cp $STRANGER $PART.$n; mv $PART.$n ${PART%000}$n; done; cp $STRANGER $TMP/$(basename ${PART%000}001)",
    ),
    (
        "plant",
        "a pipe under the archive's name, while it is recorded",
        When::During,
        "mkfifo ${PART%.part-000}; mkfifo $TMP/$(basename ${PART%.part-000})",
    ),
    ("plant", "a fallback folder", When::Before, "mkdir $TMP/haptic-camera-0 $TMP/haptic-camera-0-0000000000000000"),
    (
        "link",
        ".incomplete to the victim's file",
        When::Before,
        "each cp $STRANGER $OUT/_T_.mcap.part-001; each ln -s $SECRET $OUT/_T_.mcap.incomplete; each ln -s $SECRET $OUT/_T_.toml.incomplete; each ln -s $SECRET $TMP/_T_.mcap.incomplete",
    ),
    (
        "link",
        "parts to the victim's file",
        When::Before,
        "each ln -s $SECRET $TMP/_T_.mcap.part-001; each ln -s $SECRET $OUT/_T_.mcap.part-001",
    ),
    ("link", "the archive's name to the victim's file", When::Before, "each ln -s $SECRET $OUT/_T_.mcap"),
    (
        "link",
        "the results' names to the victim's file",
        When::Before,
        "for e in toml html json; do each ln -s $SECRET $OUT/_T_.$e; done",
    ),
    ("link", "the claim's name to the victim's file", When::Before, "each ln -s $SECRET $OUT/._T_.incomplete"),
    ("link", "hard, the victim's file as a part", When::Before, "each ln $SECRET $OUT/_T_.mcap.part-001 2> $TMP/said"),
    (
        "link",
        "shared memory to the victim's file",
        When::Before,
        "ln -s $SECRET /dev/shm/hc_${HASH}_x; ln -s $SECRET /dev/shm/${HASH}_x",
    ),
    (
        "link",
        "the runtime directory to the victim's folder",
        When::BeforeUnnamed,
        "ln -s $(dirname $SECRET) $TMP/haptic-camera-0",
    ),
    (
        "touch",
        "a name in shared memory",
        When::Before,
        "touch /dev/shm/hc_${HASH}_x /dev/shm/haptic-camera /dev/shm/haptic-camera-0",
    ),
    ("touch", "the runtime directory's name", When::BeforeUnnamed, "touch $TMP/haptic-camera-0"),
    ("touch", "the archive's names", When::Before, "each touch $OUT/_T_.mcap; each touch $OUT/_T__02.mcap"),
    ("touch", "the claims' names", When::Before, "each touch $OUT/._T_.incomplete"),
    (
        "touch",
        "all names of the running capture",
        When::During,
        "A=${PART%.mcap.part-000}; touch $A.mcap $A.toml $A.html $A.json",
    ),
    (
        "touch",
        "the running capture's part: removed, moved",
        When::During,
        "rm -f $PART && echo LEAK; mv $PART $TMP/mine && echo LEAK",
    ),
    ("flood", "1,000 names of parts", When::During, "for n in $(seq -w 1 999); do touch ${PART%000}$n; done"),
    (
        "flood",
        "4,000 names in shared memory",
        When::Before,
        "(cd /dev/shm; for i in $(seq 2000); do echo hc_${HASH}_$i haptic-camera-$i; done | xargs touch)",
    ),
    (
        "flood",
        "4,000 folders in the temporary directory",
        When::Before,
        "(cd $TMP; seq -f haptic-camera-0-%g 4000 | xargs mkdir)",
    ),
    (
        "read",
        "shared memory and the runtime directory",
        When::During,
        "for f in $SEGMENTS; do cat $f > $TMP/said && echo LEAK $f; done; ls $RIG && echo LEAK; cat $RIG/rig.lock && echo LEAK",
    ),
    (
        "read",
        "archive and memory of the processes",
        When::During,
        "cat $PART && echo LEAK; for p in $PIDS; do cat /proc/$p/environ > $TMP/said && echo LEAK; ls -l /proc/$p/fd/ > $TMP/said && echo LEAK; done",
    ),
    (
        "connect",
        "commands and a recorder of his own",
        When::During,
        "export HAPTIC_CAMERA_RUNTIME_DIR=$RIG; $BIN/haptic-camera tune && echo LEAK; $BIN/recorder --out $TMP/theirs.mcap && echo LEAK",
    ),
    (
        "signal",
        "TERM, KILL, STOP",
        When::During,
        "for p in $PIDS; do for s in TERM KILL STOP; do kill -$s $p && echo LEAK; done; done",
    ),
    (
        "signal",
        "INT, HUP, USR1",
        When::During,
        "for p in $PIDS; do for s in INT HUP USR1; do kill -$s $p && echo LEAK; done; done",
    ),
];

/// Runs a command for the names that a capture of knob 3 may have that begins in the next seconds, `_T_` in its words.
pub const EACH: &str =
    "each() { for s in $(seq 0 15); do T=$(date -d \"+$s seconds\" +%Y%m%d-%H%M%S)-knob-3; \"${@//_T_/$T}\"; done; }\n";
