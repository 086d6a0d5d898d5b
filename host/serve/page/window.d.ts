interface Window {
  /** Counters for tests; see metrics.js. */
  pxpl5: import('./picture/metrics.js').Metrics;
}
