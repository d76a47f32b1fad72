import { useStore } from "../state/store";

/** How the run of the trial goes on, in words; `otherwise` where it was not run since the page was opened. */
export function RunState({ otherwise }: { otherwise: string }): React.JSX.Element {
  const job = useStore((s) => (s.id ? s.jobs[s.id] : undefined));
  const words = { running: `${job?.stage || "Running"} ${Math.round(100 * (job?.progress ?? 0))} %`, done: "The trial was run: see Tracks.", failed: "The run came to nothing.", cancelled: "The run was stopped." };
  return <p className="soft" role="status" data-run={job?.state ?? ""}>{job ? words[job.state] : otherwise}</p>;
}
