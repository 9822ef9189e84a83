// Job type for Flamenco, Blender's render-farm manager: the umbilics of a folder of meshes.
//
// Put this file into the folder "scripts" beside the flamenco-manager program. The folder is
// dealt out to as many tasks as "parts" says; every part skips what it has done before, so that a
// task can be given to another worker at any time. Broken files do not fail their part, which the
// farm would only try again: the last task, which makes one summary of all, fails and names them.

const JOB_TYPE = {
    label: "Umbilics of many meshes",
    description: "Find the umbilical points of all mesh files in a folder",
    settings: [
        {
            key: "meshes", type: "string", subtype: "dir_path", required: true,
            description: "Folder of the mesh files; all below it is taken too",
        },
        {
            key: "results", type: "string", subtype: "dir_path", required: true,
            description: "Folder of the results and of the summary report.csv",
        },
        {
            key: "parts", type: "int32", default: 8, propargs: { min: 1, max: 1000 },
            description: "Tasks that the files are dealt out to; more than there are workers",
        },
        {
            key: "also", type: "string", default: "",
            description: "Results besides .json, with spaces between: png ply blend",
        },
        {
            key: "options", type: "string", default: "",
            description: "Further options of the command, such as: --opening 2",
        },
        {
            key: "jobs", type: "int32", default: 0, propargs: { min: 0, max: 256 },
            description: "Files at a time on each worker; 0 takes what the worker's memory holds",
            visible: "submission",
        },
    ],
};

function compileJob(job) {
    const settings = job.settings;
    const parts = Math.floor(settings.parts);
    if (!(parts >= 1)) {
        throw "parts must be 1 or more";
    }
    const summary = author.Task("summary", "blender");
    for (let part = 1; part <= parts; part++) {
        const task = author.Task(`part-${part}-of-${parts}`, "blender");
        task.addCommand(umbilics(partArguments(settings, part, parts)));
        job.addTask(task);
        summary.addDependency(task);
    }
    summary.addCommand(umbilics(["--out", settings.results, "--summary"]));
    job.addTask(summary);
}

// One run of the extension's command, by the Blender that the Manager's variables name.
function umbilics(commandArguments) {
    return author.Command("exec", {
        exe: "{blender}",
        args: ["-b", "--command", "umbilics"].concat(commandArguments),
    });
}

function partArguments(settings, part, parts) {
    let result = [settings.meshes, "--out", settings.results, "--resume", "--tolerant"];
    result = result.concat(["--part", `${part}/${parts}`]);
    if (settings.jobs > 0) {
        result = result.concat(["--jobs", String(settings.jobs)]);
    }
    for (const kind of words(settings.also)) {
        result = result.concat(["--also", kind]);
    }
    return result.concat(words(settings.options));
}

function words(text) {
    return (text || "").split(/\s+/).filter((word) => word.length > 0);
}
