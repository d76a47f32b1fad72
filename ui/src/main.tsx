import { createRoot } from "react-dom/client";
import { App } from "./App";
import { connect } from "./api/live";
import { onKey } from "./keys/bind";
import { arrive } from "./state/load";
import { fitPaper } from "./state/print";
import { followTheme } from "./state/theme";
import "./colours.css";
import "./tokens.css";
import "./base.css";

followTheme();
addEventListener("keydown", onKey);
addEventListener("beforeprint", fitPaper);
addEventListener("hashchange", () => void arrive());
createRoot(document.getElementById("root")!).render(<App />);
connect();
void arrive();
