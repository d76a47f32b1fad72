import react from "@vitejs/plugin-react";
import { defineConfig } from "vitest/config";

export default defineConfig({
  plugins: [react()],
  build: {
    outDir: "../src/kinemark/apps/studio/page",
    emptyOutDir: true,
    assetsInlineLimit: 0, // the page's policy allows no data: addresses
    modulePreload: { polyfill: false },
    cssCodeSplit: false, // 11 kB; in one file its order is the one that was written
    chunkSizeWarningLimit: 1200,
    rolldownOptions: { output: { codeSplitting: { groups: [{ name: "icons", test: /node_modules.lucide-react/ }] } } }, // else a file an icon
  },
  server: { proxy: { "/api": { target: "http://127.0.0.1:8900", ws: true } } },
  test: { include: ["tests/**/*.test.ts"], environment: "node" },
});
