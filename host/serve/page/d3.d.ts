// The page uses D3 5 as the global that /d3.js defines; its modules are not typed here.
declare const d3: any;

interface Window {
  /** Counters for tests; see metrics.js. */
  pxpl5: import('./picture/metrics.js').Metrics;
}
